#include "collab/recording/mcap_writer.h"

#include <array>
#include <bit>
#include <cstring>

#include "collab/recording/recording.h"

namespace tandem {
namespace {

constexpr std::size_t kChunkSize = std::size_t{1} << 20U;
constexpr std::array<unsigned char, 8> kMagic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};

enum class Op : std::uint8_t {
  kHeader = 1,
  kFooter,
  kSchema,
  kChannel,
  kMessage,
  kChunk,
  kMessageIndex,
  kChunkIndex,
  kStatistics = 11,
  kSummaryOffset = 14,
  kDataEnd
};

static_assert(std::endian::native == std::endian::little);

/// A record's content, field by field.
class Content {
 public:
  template <typename T>
  Content& Number(T value) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof value);
    std::memcpy(&bytes_[at], &value, sizeof value);
    return *this;
  }
  Content& Text(const std::string& text) {
    Number(static_cast<std::uint32_t>(text.size()));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    return *this;
  }
  /// Adds a list or a map: its length in bytes, then the content of `other`.
  Content& List(const Content& other) {
    Number(static_cast<std::uint32_t>(other.bytes_.size()));
    return Raw(other.bytes_);
  }
  Content& Raw(std::span<const unsigned char> bytes) {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return *this;
  }
  const Bytes& bytes() const { return bytes_; }

 private:
  Bytes bytes_;
};

Bytes Record(Op op, const Content& content) {
  Content record;
  record.Number(op).Number(std::uint64_t{content.bytes().size()}).Raw(content.bytes());
  return record.bytes();
}

void Append(Bytes& to, const Bytes& what) {
  to.insert(to.end(), what.begin(), what.end());
}

}  // namespace

Result<std::unique_ptr<McapWriter>> McapWriter::Create(const std::filesystem::path& file,
                                                       const std::string& profile,
                                                       const std::string& library) {
  Result<WholeFile> made = WholeFile::Create(file);
  if (!made) return made.error();
  std::unique_ptr<McapWriter> writer(new McapWriter(*std::move(made)));
  writer->Put(Bytes(kMagic.begin(), kMagic.end()));
  writer->Put(Record(Op::kHeader, Content().Text(profile).Text(library)));
  return writer;
}

void McapWriter::Put(const Bytes& bytes) {
  file_.Write({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  written_ += bytes.size();
  crc_ = Crc32(bytes.data(), bytes.size(), crc_);
}

std::uint16_t McapWriter::AddSchema(const std::string& name, const std::string& encoding,
                                    const std::string& text) {
  const std::uint16_t id = ++schema_count_;  // 0 is reserved
  const Bytes record =
      Record(Op::kSchema, Content().Number(id).Text(name).Text(encoding).Text(text));
  Append(schemas_, record);
  Append(chunk_.records, record);
  return id;
}

std::uint16_t McapWriter::AddChannel(std::uint16_t schema, const std::string& topic,
                                     const std::string& message_encoding,
                                     const std::map<std::string, std::string>& metadata) {
  const auto id = static_cast<std::uint16_t>(message_counts_.size());
  message_counts_.push_back(0);
  Content map;
  for (const auto& [key, value] : metadata) map.Text(key).Text(value);
  const Bytes record =
      Record(Op::kChannel,
             Content().Number(id).Number(schema).Text(topic).Text(message_encoding).List(map));
  Append(channels_, record);
  Append(chunk_.records, record);
  return id;
}

void McapWriter::Write(std::uint16_t channel, std::uint64_t time_ns,
                       std::span<const unsigned char> message) {
  if (chunk_.messages.empty()) chunk_.first_ns = time_ns;
  if (message_count_++ == 0) first_ns_ = time_ns;
  chunk_.last_ns = time_ns;
  last_ns_ = time_ns;
  chunk_.messages[channel].emplace_back(time_ns, chunk_.records.size());
  const auto number = static_cast<std::uint32_t>(message_counts_[channel]++);
  Append(chunk_.records,
         Record(Op::kMessage,
                Content().Number(channel).Number(number).Number(time_ns).Number(time_ns).Raw(
                    message)));
  if (chunk_.records.size() >= kChunkSize) EndChunk();
}

void McapWriter::EndChunk() {
  if (chunk_.records.empty()) return;
  const std::string uncompressed;
  const std::uint64_t size = chunk_.records.size();
  const std::uint64_t begin = written_;
  Put(Record(Op::kChunk, Content()
                             .Number(chunk_.first_ns)
                             .Number(chunk_.last_ns)
                             .Number(size)
                             .Number(Crc32(chunk_.records.data(), size))
                             .Text(uncompressed)
                             .Number(size)
                             .Raw(chunk_.records)));
  const std::uint64_t end = written_;
  Content places;
  for (const auto& [channel, messages] : chunk_.messages) {
    places.Number(channel).Number(written_);
    Content list;
    for (const auto& [time_ns, place] : messages) list.Number(time_ns).Number(place);
    Put(Record(Op::kMessageIndex, Content().Number(channel).List(list)));
  }
  Append(chunk_indexes_, Record(Op::kChunkIndex, Content()
                                                     .Number(chunk_.first_ns)
                                                     .Number(chunk_.last_ns)
                                                     .Number(begin)
                                                     .Number(end - begin)
                                                     .List(places)
                                                     .Number(written_ - end)
                                                     .Text(uncompressed)
                                                     .Number(size)
                                                     .Number(size)));
  ++chunk_count_;
  chunk_ = {};
}

Result<std::uint64_t> McapWriter::Close() {
  EndChunk();
  Put(Record(Op::kDataEnd, Content().Number(crc_)));

  Content counts;
  for (std::size_t i = 0; i < message_counts_.size(); ++i) {
    counts.Number(static_cast<std::uint16_t>(i)).Number(message_counts_[i]);
  }
  const Bytes statistics =
      Record(Op::kStatistics, Content()
                                  .Number(message_count_)
                                  .Number(schema_count_)
                                  .Number(static_cast<std::uint32_t>(message_counts_.size()))
                                  .Number(std::uint32_t{0})  // attachments
                                  .Number(std::uint32_t{0})  // metadata
                                  .Number(chunk_count_)
                                  .Number(first_ns_)
                                  .Number(last_ns_)
                                  .List(counts));
  crc_ = 0;  // CRC of the summary, from here on
  const std::uint64_t summary = written_;
  Bytes offsets;
  const auto put_group = [&](Op op, const Bytes& records) {
    if (records.empty()) return;
    Append(offsets, Record(Op::kSummaryOffset, Content().Number(op).Number(written_).Number(
                                                   std::uint64_t{records.size()})));
    Put(records);
  };
  put_group(Op::kSchema, schemas_);
  put_group(Op::kChannel, channels_);
  put_group(Op::kStatistics, statistics);
  put_group(Op::kChunkIndex, chunk_indexes_);
  const std::uint64_t summary_offsets = written_;
  Put(offsets);
  // the footer's CRC covers its own beginning
  Content footer;
  footer.Number(Op::kFooter).Number(std::uint64_t{20}).Number(summary).Number(summary_offsets);
  Put(footer.bytes());
  Put(Content().Number(crc_).bytes());
  Put(Bytes(kMagic.begin(), kMagic.end()));
  if (const std::optional<Error> failed = file_.Commit()) return *failed;
  return message_count_;
}

}  // namespace tandem
