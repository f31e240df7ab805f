#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/files/whole_file.h"
#include "engine/base/result.h"

namespace tandem {

using Bytes = std::vector<unsigned char>;

/// Writes an MCAP file (version 0 of its specification, mcap.dev/spec): schemas, channels and
/// messages in uncompressed chunks with their indexes, a summary, and a CRC-32 over each part. The
/// file appears when it is complete.
class McapWriter {
 public:
  /// `profile` and `library`: fields of the file's header.
  static Result<std::unique_ptr<McapWriter>> Create(const std::filesystem::path& file,
                                                    const std::string& profile,
                                                    const std::string& library);

  /// `text`: the schema itself, in the language `encoding`.
  std::uint16_t AddSchema(const std::string& name, const std::string& encoding,
                          const std::string& text);
  std::uint16_t AddChannel(std::uint16_t schema, const std::string& topic,
                           const std::string& message_encoding,
                           const std::map<std::string, std::string>& metadata);
  /// Writes a message; called in the order of `time_ns`.
  void Write(std::uint16_t channel, std::uint64_t time_ns, std::span<const unsigned char> message);

  /// Writes the rest. Returns the number of messages; an error names the file.
  Result<std::uint64_t> Close();

 private:
  struct Chunk {
    Bytes records;
    std::uint64_t first_ns = 0;
    std::uint64_t last_ns = 0;
    // by channel: times of its messages, and their offsets in `records`
    std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> messages;
  };

  explicit McapWriter(WholeFile file) : file_(std::move(file)) {}
  void Put(const Bytes& bytes);
  void EndChunk();

  WholeFile file_;
  std::uint64_t written_ = 0;  // bytes
  std::uint32_t crc_ = 0;      // CRC of the bytes written
  Chunk chunk_;
  Bytes schemas_;        // records, for the summary
  Bytes channels_;       // the same
  Bytes chunk_indexes_;  // the same
  std::uint16_t schema_count_ = 0;
  std::uint32_t chunk_count_ = 0;
  std::uint64_t first_ns_ = 0;
  std::uint64_t last_ns_ = 0;
  std::uint64_t message_count_ = 0;
  std::vector<std::uint64_t> message_counts_;  // by channel
};

}  // namespace tandem
