// SPDX-License-Identifier: Apache-2.0
#include "formats/text_source.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace diesink {
namespace {

class FileText final : public TextSource {
 public:
  FileText(int file, std::string path)
      : file_(file), path_(std::move(path)), block_(std::make_unique<char[]>(kBlock)) {}
  FileText(const FileText&) = delete;
  FileText& operator=(const FileText&) = delete;
  ~FileText() override { ::close(file_); }

  std::string_view next() override {
    while (status_) {
      const ssize_t got = ::pread(file_, block_.get(), kBlock, at_);
      if (got >= 0) {
        at_ += got;
        return {block_.get(), static_cast<std::size_t>(got)};
      }
      if (errno != EINTR) {
        status_ = Error{ErrorCode::kInput,
                        std::string("cannot read: ") + std::strerror(errno),
                        {path_, 0, 0, -1}};
      }
    }
    return {};
  }
  void rewind() override { at_ = 0; }
  [[nodiscard]] Status status() const override { return status_; }

 private:
  static constexpr std::size_t kBlock = std::size_t{1} << 20;
  int file_;
  std::string path_;
  std::unique_ptr<char[]> block_;
  off_t at_ = 0;
  Status status_ = ok();
};

}  // namespace

Result<std::unique_ptr<TextSource>> open_text(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) {
    return Error{
        ErrorCode::kInput, std::string("cannot read: ") + std::strerror(errno), {path, 0, 0, -1}};
  }
  auto source = std::make_unique<FileText>(file, path);
  struct stat found {};
  if (::fstat(file, &found) != 0 || !S_ISREG(found.st_mode)) {
    return Error{ErrorCode::kInput, "cannot read: it is no regular file", {path, 0, 0, -1}};
  }
  return std::unique_ptr<TextSource>(std::move(source));
}

}  // namespace diesink
