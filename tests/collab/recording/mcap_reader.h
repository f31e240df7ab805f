#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace tandem::testing {

/// Reads an MCAP file by its specification (mcap.dev/spec) and by nothing of ours. Content that is
/// not as specified is a failure of the test. The reader knows no compression, attachments or
/// metadata.
class McapReader {
 public:
  struct Schema {
    std::string name, encoding, text;
  };
  struct Channel {
    std::uint16_t schema = 0;
    std::string topic, encoding;
  };
  struct Message {
    std::uint16_t channel = 0;
    std::uint32_t sequence = 0;
    std::uint64_t log_ns = 0, publish_ns = 0;
    std::string data;
  };

  explicit McapReader(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(stream), {});
    ReadFile();
  }

  std::string profile;
  std::map<std::uint16_t, Schema> schemas;
  std::map<std::uint16_t, Channel> channels;
  std::vector<Message> messages;
  int chunks = 0;
  bool whole = false;  // down to the last byte

  /// Returns the messages of a topic, in their order.
  std::vector<Message> MessagesOf(const std::string& topic) const {
    std::vector<Message> of_topic;
    for (const Message& message : messages) {
      if (channels.at(message.channel).topic == topic) of_topic.push_back(message);
    }
    return of_topic;
  }
  std::string TypeOf(const std::string& topic) const {
    for (const auto& [id, channel] : channels) {
      if (channel.topic == topic) return schemas.at(channel.schema).name;
    }
    return {};
  }

 private:
  /// Takes fields from a text; beyond its end it fails.
  struct Fields {
    std::string text;
    std::size_t at = 0;
    template <typename T>
    T Number() {
      T value{};
      const std::string bytes = Take(sizeof value);
      if (bytes.size() == sizeof value) std::memcpy(&value, bytes.data(), sizeof value);
      return value;
    }
    std::string Take(std::uint64_t size) {
      if (size > text.size() - at) {
        ADD_FAILURE() << "a record ends within a field";
        at = text.size();
        return {};
      }
      at += size;
      return text.substr(at - size, size);
    }
    std::string Text() { return Take(Number<std::uint32_t>()); }
    bool done() const { return at == text.size(); }
  };
  struct Record {
    std::uint8_t op = 0;
    std::uint64_t begin = 0, end = 0;  // places in the file
    std::string content;
  };

  // bit by bit, as in the standard that MCAP names
  static std::uint32_t Crc(const std::string& text) {
    std::uint32_t crc = ~0U;
    for (const char c : text) {
      crc ^= static_cast<unsigned char>(c);
      for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1U ^ 0xEDB88320U : crc >> 1U;
    }
    return ~crc;
  }

  static Record Next(Fields& from) {
    Record record;
    record.begin = from.at;
    record.op = from.Number<std::uint8_t>();
    record.content = from.Take(from.Number<std::uint64_t>());
    record.end = from.at;
    return record;
  }

  void ReadFile() {
    const std::string magic("\x89MCAP0\r\n", 8);
    ASSERT_GE(bytes_.size(), 16U);
    ASSERT_EQ(bytes_.substr(0, 8), magic);
    ASSERT_EQ(bytes_.substr(bytes_.size() - 8), magic);
    Fields file{bytes_.substr(0, bytes_.size() - 8), 8};
    const Record header = Next(file);
    ASSERT_EQ(header.op, 1);
    profile = Fields{header.content}.Text();
    while (!::testing::Test::HasFailure()) {
      const Record record = Next(file);
      if (record.op == 15) {
        EXPECT_EQ(Fields{record.content}.Number<std::uint32_t>(),
                  Crc(bytes_.substr(0, record.begin)));
        break;
      }
      ReadData(record);
    }
    ReadSummary(file);
  }

  void ReadData(const Record& record) {
    if (record.op == 6) {
      ReadChunk(record);
    } else if (record.op == 7) {
      ReadMessageIndex(record);
    } else {
      ADD_FAILURE() << "a record of kind " << int{record.op} << " outside of chunks";
    }
  }

  void ReadChunk(const Record& record) {
    Fields fields{record.content};
    const auto first = fields.Number<std::uint64_t>();
    const auto last = fields.Number<std::uint64_t>();
    const auto size = fields.Number<std::uint64_t>();
    const auto crc = fields.Number<std::uint32_t>();
    EXPECT_EQ(fields.Text(), "");
    EXPECT_EQ(fields.Number<std::uint64_t>(), size);
    Fields records{fields.Take(size)};
    EXPECT_TRUE(fields.done());
    EXPECT_EQ(Crc(records.text), crc);
    places_.clear();
    ++chunks;
    chunk_ = record;
    while (!records.done()) {
      const Record inner = Next(records);
      if (inner.op == 3) ReadSchema(inner.content, true);
      if (inner.op == 4) ReadChannel(inner.content, true);
      if (inner.op != 5) continue;
      Fields message{inner.content};
      Message read;
      read.channel = message.Number<std::uint16_t>();
      read.sequence = message.Number<std::uint32_t>();
      read.log_ns = message.Number<std::uint64_t>();
      read.publish_ns = message.Number<std::uint64_t>();
      read.data = message.text.substr(message.at);
      EXPECT_TRUE(channels.contains(read.channel)) << "a message before its channel";
      EXPECT_TRUE(first <= read.log_ns && read.log_ns <= last);
      places_[read.channel].emplace_back(read.log_ns, inner.begin);
      messages.push_back(std::move(read));
    }
  }

  void ReadMessageIndex(const Record& record) {
    Fields fields{record.content};
    const auto channel = fields.Number<std::uint16_t>();
    Fields list{fields.Text()};
    std::vector<std::pair<std::uint64_t, std::uint64_t>> places;
    while (!list.done()) {
      const auto time = list.Number<std::uint64_t>();
      places.emplace_back(time, list.Number<std::uint64_t>());
    }
    EXPECT_EQ(places, places_[channel]);
    index_of_[{chunk_.begin, channel}] = record.begin;
    index_end_[chunk_.begin] = record.end;
  }

  void ReadSchema(const std::string& content, bool is_new) {
    Fields fields{content};
    const auto id = fields.Number<std::uint16_t>();
    Schema schema;
    schema.name = fields.Text();
    schema.encoding = fields.Text();
    schema.text = fields.Text();
    EXPECT_TRUE(id != 0 && fields.done());
    EXPECT_NE(schemas.contains(id), is_new);
    schemas[id] = schema;
  }

  void ReadChannel(const std::string& content, bool is_new) {
    Fields fields{content};
    const auto id = fields.Number<std::uint16_t>();
    Channel channel;
    channel.schema = fields.Number<std::uint16_t>();
    channel.topic = fields.Text();
    channel.encoding = fields.Text();
    Fields metadata{fields.Text()};
    while (!metadata.done()) {
      metadata.Text();
      metadata.Text();
    }
    EXPECT_TRUE(fields.done());
    EXPECT_TRUE(schemas.contains(channel.schema));
    EXPECT_NE(channels.contains(id), is_new);
    channels[id] = channel;
  }

  void ReadSummary(Fields& file) {
    const std::uint64_t summary = file.at;
    std::map<std::uint8_t, std::pair<std::uint64_t, std::uint64_t>> groups;  // begin, length
    std::uint64_t offsets = 0;
    int indexes = 0;
    while (!::testing::Test::HasFailure()) {
      const Record record = Next(file);
      Fields fields{record.content};
      if (record.op == 2) {
        EXPECT_EQ(fields.Number<std::uint64_t>(), summary);
        EXPECT_EQ(fields.Number<std::uint64_t>(), offsets);
        EXPECT_EQ(fields.Number<std::uint32_t>(),
                  Crc(bytes_.substr(summary, record.end - 4 - summary)));
        whole = fields.done() && file.done();
        break;
      }
      if (record.op == 14) {
        if (offsets == 0) offsets = record.begin;
        const auto op = fields.Number<std::uint8_t>();
        EXPECT_EQ(fields.Number<std::uint64_t>(), groups[op].first);
        EXPECT_EQ(fields.Number<std::uint64_t>(), groups[op].second);
        continue;
      }
      auto& [begin, length] = groups[record.op];
      if (length == 0) begin = record.begin;
      EXPECT_EQ(begin + length, record.begin) << "records of a kind lie together";
      length += record.end - record.begin;
      if (record.op == 3) ReadSchema(record.content, false);
      if (record.op == 4) ReadChannel(record.content, false);
      if (record.op == 8) ++indexes, ReadChunkIndex(fields);
      if (record.op == 11) ReadStatistics(fields);
    }
    EXPECT_EQ(indexes, chunks);
    EXPECT_TRUE(groups.contains(11));
  }

  void ReadChunkIndex(Fields& fields) {
    fields.Number<std::uint64_t>();
    fields.Number<std::uint64_t>();
    const auto begin = fields.Number<std::uint64_t>();
    const auto length = fields.Number<std::uint64_t>();
    Fields places{fields.Text()};
    while (!places.done()) {
      const auto channel = places.Number<std::uint16_t>();
      EXPECT_EQ(places.Number<std::uint64_t>(), (index_of_[{begin, channel}]));
    }
    EXPECT_EQ(fields.Number<std::uint64_t>(), index_end_[begin] - begin - length);
    EXPECT_EQ(bytes_.at(begin), 6);
  }

  void ReadStatistics(Fields& fields) {
    EXPECT_EQ(fields.Number<std::uint64_t>(), messages.size());
    EXPECT_EQ(fields.Number<std::uint16_t>(), schemas.size());
    EXPECT_EQ(fields.Number<std::uint32_t>(), channels.size());
    EXPECT_EQ(fields.Number<std::uint32_t>(), 0U);
    EXPECT_EQ(fields.Number<std::uint32_t>(), 0U);
    EXPECT_EQ(fields.Number<std::uint32_t>(), static_cast<std::uint32_t>(chunks));
    EXPECT_EQ(fields.Number<std::uint64_t>(), messages.empty() ? 0 : messages.front().log_ns);
    EXPECT_EQ(fields.Number<std::uint64_t>(), messages.empty() ? 0 : messages.back().log_ns);
    Fields counts{fields.Text()};
    std::map<std::uint16_t, std::uint64_t> counted;
    for (const Message& message : messages) ++counted[message.channel];
    while (!counts.done()) {
      const auto channel = counts.Number<std::uint16_t>();
      EXPECT_EQ(counts.Number<std::uint64_t>(), counted[channel]);
    }
  }

  std::string bytes_;
  Record chunk_;
  std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> places_;
  std::map<std::pair<std::uint64_t, std::uint16_t>, std::uint64_t> index_of_;
  std::map<std::uint64_t, std::uint64_t> index_end_;
};

}  // namespace tandem::testing
