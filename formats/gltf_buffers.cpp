// SPDX-License-Identifier: Apache-2.0
#include "formats/gltf_buffers.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "formats/input_file.h"

namespace diesink {
namespace {

Error wrong(std::size_t buffer, std::string what) {
  return Error{ErrorCode::kInput, "buffers[" + std::to_string(buffer) + "] " + std::move(what), {}};
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

// Percent escapes undone, once; empty optional where one is broken.
std::optional<std::string> unescaped(std::string_view uri) {
  std::string out;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] != '%') {
      out += uri[i];
      continue;
    }
    const int high = i + 2 < uri.size() ? hex_digit(uri[i + 1]) : -1;
    const int low = i + 2 < uri.size() ? hex_digit(uri[i + 2]) : -1;
    if (high < 0 || low < 0) return std::nullopt;
    out += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return out;
}

// Whether `name` is a path downward from a folder, without leaving it on the way.
bool stays_below(std::string_view name) {
  if (name.empty() || name.front() == '/' || name.find('\0') != std::string_view::npos ||
      name.find('\\') != std::string_view::npos || name.find(':') != std::string_view::npos) {
    return false;
  }
  std::size_t begin = 0;
  while (begin <= name.size()) {
    const std::size_t end = std::min(name.find('/', begin), name.size());
    if (name.substr(begin, end - begin) == "..") return false;
    begin = end + 1;
  }
  return true;
}

std::optional<std::string> real_path(const std::string& path) {
  const std::unique_ptr<char, decltype(&std::free)> real(realpath(path.c_str(), nullptr),
                                                         &std::free);
  if (!real) return std::nullopt;
  return std::string(real.get());
}

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

// The first `length` bytes of a file below the folder.
Result<std::vector<std::byte>> read_beside(const std::string& name, std::size_t length,
                                           std::size_t number, const ReadOptions& options) {
  const std::string path = options.folder + '/' + name;
  const std::optional<std::string> folder = real_path(options.folder);
  const std::optional<std::string> real = real_path(path);
  if (!folder || !real) return wrong(number, "is in \"" + name + "\", which cannot be opened");
  const std::string below = *folder == "/" ? "/" : *folder + '/';
  if (!real->starts_with(below)) {
    return wrong(number, "is in \"" + name + "\", which lies outside the file's folder");
  }
  if (const std::optional<std::string> self = real_path(options.file_name);
      self && *self == *real) {
    return wrong(number, "is in \"" + name + "\", which is the glTF file itself");
  }
  // Never waits for a pipe, and what is opened is looked at before a byte is read.
  const Descriptor file(open(real->c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW));
  struct stat about {};
  if (file.get() < 0 || fstat(file.get(), &about) != 0) {
    return wrong(number, "is in \"" + name + "\", which cannot be opened");
  }
  if (!S_ISREG(about.st_mode)) {
    return wrong(number, "is in \"" + name + "\", which is no regular file");
  }
  if (static_cast<std::uint64_t>(about.st_size) < length) {
    return wrong(number, "claims " + std::to_string(length) + " bytes, \"" + name + "\" has " +
                             std::to_string(about.st_size));
  }
  std::vector<std::byte> bytes(length);
  std::size_t done = 0;
  while (done < length) {
    const ssize_t got = read(file.get(), bytes.data() + done, length - done);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return wrong(number, "is in \"" + name + "\", which cannot be read");
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

std::array<std::int8_t, 256> base64_values() {
  std::array<std::int8_t, 256> values{};
  values.fill(-1);
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < kDigits.size(); ++i) {
    values[static_cast<unsigned char>(kDigits[i])] = static_cast<std::int8_t>(i);
  }
  return values;
}

// The bytes of base64 digits; empty optional where they are none.
std::optional<std::vector<std::byte>> from_base64(std::string_view text) {
  static const std::array<std::int8_t, 256> values = base64_values();
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  if (text.size() % 4 == 1) return std::nullopt;
  std::vector<std::byte> bytes;
  bytes.reserve(text.size() / 4 * 3 + 3);
  std::uint32_t bits = 0;
  int held = 0;
  for (const char c : text) {
    const std::int8_t value = values[static_cast<unsigned char>(c)];
    if (value < 0) return std::nullopt;
    bits = bits << 6 | static_cast<std::uint32_t>(value);
    held += 6;
    if (held >= 8) {
      held -= 8;
      bytes.push_back(static_cast<std::byte>(bits >> held & 0xFF));
    }
  }
  return bytes;
}

// "data:application/octet-stream;base64,AAAA"
Result<std::vector<std::byte>> from_data_uri(std::string_view uri, std::size_t length,
                                             std::size_t number) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos || !uri.substr(0, comma).ends_with(";base64")) {
    return wrong(number, "has a data URI that is not base64");
  }
  const std::string_view digits = uri.substr(comma + 1);
  if (length > digits.size()) {  // before anything is decoded
    return wrong(number, "claims " + std::to_string(length) + " bytes in " +
                             std::to_string(digits.size()) + " base64 digits");
  }
  std::optional<std::vector<std::byte>> bytes = from_base64(digits);
  if (!bytes) return wrong(number, "has a data URI with characters that are not base64");
  if (bytes->size() < length) {
    return wrong(number, "claims " + std::to_string(length) + " bytes, its data URI holds " +
                             std::to_string(bytes->size()));
  }
  return std::move(*bytes);
}

Result<std::vector<std::byte>> from_uri(const GltfBufferSource& source, std::size_t number,
                                        const ReadOptions& options) {
  if (source.uri.starts_with("data:")) return from_data_uri(source.uri, source.length, number);
  const std::optional<std::string> name = unescaped(source.uri);
  if (!name || !stays_below(*name)) {
    return wrong(number, "has the URI \"" + source.uri.substr(0, 60) +
                             "\", expected a file below the file's folder");
  }
  if (options.folder.empty()) {
    return wrong(number, "is in another file, \"" + name->substr(0, 60) +
                             "\", and there is no folder to look in");
  }
  if (source.length > kMaxFileBytes) {
    return Error{ErrorCode::kLimit,
                 "buffers[" + std::to_string(number) + "] claims " + std::to_string(source.length) +
                     " bytes, at most " + std::to_string(kMaxFileBytes) + " are read",
                 {}};
  }
  return read_beside(*name, source.length, number, options);
}

}  // namespace

Result<std::vector<GltfBuffer>> resolve_buffers(const std::vector<GltfBufferSource>& sources,
                                                std::span<const std::byte> glb_buffer,
                                                bool has_glb_buffer, const ReadOptions& options,
                                                Diagnostics& diagnostics) {
  std::vector<GltfBuffer> buffers;
  buffers.reserve(sources.size());
  bool glb_used = false;
  std::size_t total = 0;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const GltfBufferSource& source = sources[i];
    GltfBuffer buffer;
    if (source.has_uri) {
      auto bytes = from_uri(source, i, options);
      if (!bytes) return bytes.error();
      total += bytes->size();
      if (total > options.max_memory) {
        return Error{ErrorCode::kLimit, "the buffers need more memory than allowed", {}};
      }
      if (bytes->size() > source.length + 3) {
        diagnostics.warning("buffers[" + std::to_string(i) + "] holds more bytes than it claims",
                            Place{options.file_name});
      }
      buffer.owned = std::move(*bytes);
      buffer.bytes = std::span(buffer.owned).first(source.length);
    } else if (i == 0 && has_glb_buffer && !source.fallback) {
      if (source.length > glb_buffer.size()) {
        return wrong(i, "claims " + std::to_string(source.length) + " bytes, the GLB's has " +
                            std::to_string(glb_buffer.size()));
      }
      if (glb_buffer.size() > source.length + 3) {
        diagnostics.warning("the GLB's buffer is longer than the JSON says",
                            Place{options.file_name});
      }
      glb_used = true;
      buffer.bytes = glb_buffer.first(source.length);
    } else if (source.fallback) {
      buffer.missing = true;
    } else {
      return wrong(i, "has no URI, and the file no buffer of its own for it");
    }
    buffers.push_back(std::move(buffer));
  }
  if (has_glb_buffer && !glb_used && !glb_buffer.empty()) {
    diagnostics.warning("the GLB's buffer is not used", Place{options.file_name});
  }
  return buffers;
}

}  // namespace diesink
