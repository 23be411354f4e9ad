// Writes a file in the MCAP format: records in chunks, with an index and checksums, without compression.
//
// Source: the open MCAP specification, version 0: magic, Header, Chunk and MessageIndex records, DataEnd, the summary
// (Schema, Channel, Statistics, ChunkIndex, SummaryOffset), Footer, magic. Little endian. Reading such a file by time
// or topic needs only its summary and the chunks concerned. Each chunk and the summary have a checksum; the optional
// one of the whole data section is left out: it would cover the same bytes again.
// Thread: any normal one. Bound: a chunk of about 1 MB in memory, and 100 bytes of index for each chunk. Errors: those
// of the file.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tools/export/output_file.h"

namespace tactus::exporting {

class McapWriter {
 public:
  McapWriter(std::unique_ptr<OutputFile> file, std::string_view library);

  // Before the first message. Schemas are JSON Schema texts and messages JSON. Returns the channel's number.
  std::uint16_t add_channel(const std::string& topic, const std::string& schema_name, const std::string& json_schema);

  // `time_ns`: of the log and of publication. Messages come in the order of time.
  void message(std::uint16_t channel, std::uint64_t time_ns, std::string_view json);

  const Status& status() const noexcept { return file_->status(); }
  std::uint64_t bytes() const noexcept { return file_->bytes(); }
  Status finish();

 private:
  struct Channel {
    std::string topic, schema_name, schema;
    std::uint32_t messages{0};
    std::vector<std::pair<std::uint64_t, std::uint64_t>> index;  // of the open chunk: time, offset in it
  };
  struct ChunkEntry {
    std::uint64_t first_ns{0}, last_ns{0}, offset{0}, length{0}, index_length{0}, size{0};
    std::map<std::uint16_t, std::uint64_t> indices;  // by channel: offset of its MessageIndex
  };

  void describe_channels(std::string& out) const;
  void close_chunk();
  std::string summary_groups(std::uint64_t summary_start, std::string& offsets) const;
  std::string statistics() const;

  std::unique_ptr<OutputFile> file_;
  std::vector<Channel> channels_;  // channel n has number n + 1 and schema n + 1
  std::string chunk_;
  std::uint64_t first_ns_{0}, last_ns_{0};  // of the open chunk
  std::uint64_t begin_ns_{0}, end_ns_{0};   // of all messages
  std::vector<ChunkEntry> chunks_;
};

}  // namespace tactus::exporting
