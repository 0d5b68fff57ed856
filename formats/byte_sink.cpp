// SPDX-License-Identifier: Apache-2.0
#include "formats/byte_sink.h"

#include <cstring>

#include "core/parallel.h"
#include "formats/text_number.h"

namespace diesink {

Result<ByteSink*> MemoryFiles::file(std::string_view name) {
  sinks_.push_back(std::make_unique<Sink>());
  sinks_.back()->file.name = std::string(name);
  return static_cast<ByteSink*>(sinks_.back().get());
}

std::vector<FileBytes> MemoryFiles::take() {
  std::vector<FileBytes> files;
  for (const std::unique_ptr<Sink>& sink : sinks_) files.push_back(std::move(sink->file));
  sinks_.clear();
  return files;
}

Status MemoryFiles::Sink::put(std::span<const std::byte> bytes) {
  file.bytes.insert(file.bytes.end(), bytes.begin(), bytes.end());
  return ok();
}

ByteWriter::ByteWriter(ByteSink& sink) : sink_(sink), buffer_(new char[kBuffer]) {}

void ByteWriter::flush() {
  if (status_ && used_ > 0) status_ = sink_.put(std::as_bytes(std::span(buffer_.get(), used_)));
  used_ = 0;
  if (expected_ > 0) {
    tell_progress(static_cast<double>(passed_) / static_cast<double>(expected_));
  }
}

ByteWriter& ByteWriter::operator<<(std::string_view text) {
  if (text.size() >= kBuffer) {
    flush();
    if (status_) status_ = sink_.put(std::as_bytes(std::span(text)));
    return *this;
  }
  while (!text.empty()) {
    char* const at = room(1);
    const std::size_t part = std::min(text.size(), kBuffer - used_);
    std::memcpy(at, text.data(), part);
    wrote(at + part);
    text.remove_prefix(part);
  }
  return *this;
}

ByteWriter& ByteWriter::operator<<(char c) {
  char* const at = room(1);
  *at = c;
  wrote(at + 1);
  return *this;
}

ByteWriter& ByteWriter::operator<<(double number) {
  wrote(put_number(room(kMaxNumberText), number));
  return *this;
}

ByteWriter& ByteWriter::operator<<(std::uint64_t number) {
  wrote(put_integer(room(kMaxNumberText), number));
  return *this;
}

Status ByteWriter::finish() {
  flush();
  return status_;
}

}  // namespace diesink
