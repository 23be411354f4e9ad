#include "tools/export/mcap_writer.h"

#include <bit>
#include <concepts>
#include <span>

#include "rt/base/crc32.h"

namespace tactus::exporting {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they are in memory");

constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};
constexpr std::size_t kChunkBytes = 1u << 20;

enum class Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0b,
  kSummaryOffset = 0x0e,
  kDataEnd = 0x0f,
};

template <std::unsigned_integral T>
void put(std::string& out, T number) {
  out.append(reinterpret_cast<const char*>(&number), sizeof number);
}

void put_text(std::string& out, std::string_view text) {
  put(out, static_cast<std::uint32_t>(text.size()));
  out.append(text);
}

void put_record(std::string& out, Opcode opcode, std::string_view content) {
  put(out, static_cast<std::uint8_t>(opcode));
  put(out, std::uint64_t{content.size()});
  out.append(content);
}

std::uint32_t crc_of(std::string_view bytes) {
  Crc32 crc;
  crc.add_bytes(std::as_bytes(std::span(bytes.data(), bytes.size())));
  return crc.value();
}

std::string schema_record(std::uint16_t number, const std::string& name, const std::string& schema) {
  std::string content;
  put(content, number);
  put_text(content, name);
  put_text(content, "jsonschema");
  put_text(content, schema);
  return content;
}

std::string channel_record(std::uint16_t number, const std::string& topic) {
  std::string content;
  put(content, number);
  put(content, number);  // its schema
  put_text(content, topic);
  put_text(content, "json");
  put(content, std::uint32_t{0});  // no metadata
  return content;
}

}  // namespace

McapWriter::McapWriter(std::unique_ptr<OutputFile> file, std::string_view library) : file_(std::move(file)) {
  std::string header, record;
  put_text(header, "");  // no profile
  put_text(header, library);
  put_record(record, Opcode::kHeader, header);
  file_->write(kMagic);
  file_->write(record);
}

std::uint16_t McapWriter::add_channel(const std::string& topic, const std::string& schema_name,
                                      const std::string& json_schema) {
  channels_.push_back({.topic = topic, .schema_name = schema_name, .schema = json_schema, .messages = 0, .index = {}});
  return static_cast<std::uint16_t>(channels_.size());
}

void McapWriter::message(std::uint16_t channel, std::uint64_t time_ns, std::string_view json) {
  Channel& on = channels_[channel - 1u];
  if (chunk_.empty()) {
    if (chunks_.empty()) {
      begin_ns_ = time_ns;
      describe_channels(chunk_);
    }
    first_ns_ = time_ns;
  }
  on.index.emplace_back(time_ns, chunk_.size());
  put(chunk_, static_cast<std::uint8_t>(Opcode::kMessage));
  put(chunk_, std::uint64_t{2 + 4 + 8 + 8 + json.size()});
  put(chunk_, channel);
  put(chunk_, on.messages++);
  put(chunk_, time_ns);
  put(chunk_, time_ns);
  chunk_.append(json);
  last_ns_ = end_ns_ = time_ns;
  if (chunk_.size() >= kChunkBytes) close_chunk();
}

Status McapWriter::finish() {
  close_chunk();
  std::string end, record;
  put(end, std::uint32_t{0});  // no checksum of the data section
  put_record(record, Opcode::kDataEnd, end);
  file_->write(record);

  const std::uint64_t summary_start = file_->bytes();
  std::string offsets;
  std::string summary = summary_groups(summary_start, offsets);
  const std::uint64_t offsets_start = summary_start + summary.size();
  summary += offsets;
  // The checksum covers the summary and the footer up to the checksum itself.
  put(summary, static_cast<std::uint8_t>(Opcode::kFooter));
  put(summary, std::uint64_t{8 + 8 + 4});
  put(summary, summary_start);
  put(summary, offsets_start);
  put(summary, crc_of(summary));
  file_->write(summary);
  file_->write(kMagic);
  return file_->finish();
}

void McapWriter::describe_channels(std::string& out) const {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const auto number = static_cast<std::uint16_t>(i + 1);
    put_record(out, Opcode::kSchema, schema_record(number, channels_[i].schema_name, channels_[i].schema));
    put_record(out, Opcode::kChannel, channel_record(number, channels_[i].topic));
  }
}

void McapWriter::close_chunk() {
  if (chunk_.empty()) return;
  ChunkEntry entry{.first_ns = first_ns_,
                   .last_ns = last_ns_,
                   .offset = file_->bytes(),
                   .length = 0,
                   .index_length = 0,
                   .size = chunk_.size(),
                   .indices = {}};
  std::string content, record;
  put(content, first_ns_);
  put(content, last_ns_);
  put(content, std::uint64_t{chunk_.size()});
  put(content, crc_of(chunk_));
  put_text(content, "");  // no compression
  put(content, std::uint64_t{chunk_.size()});
  put(record, static_cast<std::uint8_t>(Opcode::kChunk));
  put(record, std::uint64_t{content.size() + chunk_.size()});
  for (const std::string_view part : {std::string_view(record), std::string_view(content), std::string_view(chunk_)})
    file_->write(part);
  entry.length = record.size() + content.size() + chunk_.size();
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    auto& index = channels_[i].index;
    if (index.empty()) continue;
    const auto number = static_cast<std::uint16_t>(i + 1);
    entry.indices[number] = file_->bytes();
    content.clear();
    record.clear();
    put(content, number);
    put(content, static_cast<std::uint32_t>(index.size() * 16));
    for (const auto& [time_ns, offset] : index) {
      put(content, time_ns);
      put(content, offset);
    }
    put_record(record, Opcode::kMessageIndex, content);
    file_->write(record);
    entry.index_length += record.size();
    index.clear();
  }
  chunks_.push_back(std::move(entry));
  chunk_.clear();
}

std::string McapWriter::statistics() const {
  std::uint64_t messages = 0;
  for (const Channel& channel : channels_) messages += channel.messages;
  std::string content;
  put(content, messages);
  put(content, static_cast<std::uint16_t>(channels_.size()));  // schemas
  put(content, static_cast<std::uint32_t>(channels_.size()));
  put(content, std::uint32_t{0});  // attachments
  put(content, std::uint32_t{0});  // metadata
  put(content, static_cast<std::uint32_t>(chunks_.size()));
  put(content, begin_ns_);
  put(content, end_ns_);
  put(content, static_cast<std::uint32_t>(channels_.size() * 10));
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    put(content, static_cast<std::uint16_t>(i + 1));
    put(content, std::uint64_t{channels_[i].messages});
  }
  return content;
}

// The summary's records, each kind together, and in `offsets` where each kind begins.
std::string McapWriter::summary_groups(std::uint64_t summary_start, std::string& offsets) const {
  std::string summary;
  const auto end_group = [&](Opcode opcode, std::size_t begin) {
    if (summary.size() == begin) return;
    std::string content;
    put(content, static_cast<std::uint8_t>(opcode));
    put(content, summary_start + begin);
    put(content, std::uint64_t{summary.size() - begin});
    put_record(offsets, Opcode::kSummaryOffset, content);
  };
  std::size_t begin = 0;
  for (std::size_t i = 0; i < channels_.size(); ++i)
    put_record(summary, Opcode::kSchema,
               schema_record(static_cast<std::uint16_t>(i + 1), channels_[i].schema_name, channels_[i].schema));
  end_group(Opcode::kSchema, begin);
  begin = summary.size();
  for (std::size_t i = 0; i < channels_.size(); ++i)
    put_record(summary, Opcode::kChannel, channel_record(static_cast<std::uint16_t>(i + 1), channels_[i].topic));
  end_group(Opcode::kChannel, begin);
  begin = summary.size();
  put_record(summary, Opcode::kStatistics, statistics());
  end_group(Opcode::kStatistics, begin);
  begin = summary.size();
  for (const ChunkEntry& chunk : chunks_) {
    std::string content;
    for (const std::uint64_t number : {chunk.first_ns, chunk.last_ns, chunk.offset, chunk.length}) put(content, number);
    put(content, static_cast<std::uint32_t>(chunk.indices.size() * 10));
    for (const auto& [channel, offset] : chunk.indices) {
      put(content, channel);
      put(content, offset);
    }
    put(content, chunk.index_length);
    put_text(content, "");  // no compression
    put(content, chunk.size);
    put(content, chunk.size);
    put_record(summary, Opcode::kChunkIndex, content);
  }
  end_group(Opcode::kChunkIndex, begin);
  return summary;
}

}  // namespace tactus::exporting
