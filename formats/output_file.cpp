// SPDX-License-Identifier: Apache-2.0
#include "formats/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace diesink {
namespace {

// Names of the temporary files, where a signal handler can read them: no allocation, no lock. A
// slot's text is complete before its state says so.
enum class Slot : int { kFree, kFilling, kUsed };
constexpr std::size_t kSlots = 256;
std::array<std::atomic<Slot>, kSlots> slot_state{};
std::array<std::array<char, PATH_MAX>, kSlots> slot_path{};
std::atomic<unsigned> next_number{0};
std::atomic<std::uint64_t> total_written{0};

constexpr std::size_t kNoSlot = kSlots;

std::size_t take_slot(const std::string& path) {
  if (path.size() >= PATH_MAX) return kNoSlot;
  for (std::size_t i = 0; i < kSlots; ++i) {
    Slot free = Slot::kFree;
    if (slot_state[i].compare_exchange_strong(free, Slot::kFilling)) {
      std::memcpy(slot_path[i].data(), path.c_str(), path.size() + 1);
      slot_state[i].store(Slot::kUsed);
      return i;
    }
  }
  return kNoSlot;
}

void free_slot(std::size_t slot) {
  if (slot != kNoSlot) slot_state[slot].store(Slot::kFree);
}

Error cannot(std::string_view what, const std::string& path, int reason) {
  std::string message = "cannot ";
  message += what;
  message += ": ";
  message += std::strerror(reason);
  return {ErrorCode::kOutput, std::move(message), {path}};
}

std::string folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

std::string_view name_of(std::string_view path) {
  const std::size_t slash = path.rfind('/');
  return slash == path.npos ? path : path.substr(slash + 1);
}

// A folder that cannot be synced (some network and FUSE file systems) is no failed output.
Status sync_folder(const std::string& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return ok();
  const int failed = ::fsync(descriptor) != 0 ? errno : 0;
  ::close(descriptor);
  if (failed != 0 && failed != EINVAL && failed != ENOTSUP && failed != EROFS) {
    return cannot("sync the folder", folder, failed);
  }
  return ok();
}

}  // namespace

class OutputFiles::Sink final : public ByteSink {
 public:
  Sink() = default;
  Sink(const Sink&) = delete;
  Sink& operator=(const Sink&) = delete;
  ~Sink() override {
    if (descriptor_ >= 0) ::close(descriptor_);
    drop_temporary();
  }

  Status open(const std::string& path) {
    shown_ = path;
    if (path == "-") {
      // A copy, so that closing it tells what stdout has to say without taking it from the others.
      shown_ = "stdout";
      descriptor_ = ::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3);
      if (descriptor_ < 0) return cannot("write", shown_, errno);
      return ok();
    }
    target_ = path;
    if (path.empty()) return cannot("write a file without a name", path, ENOENT);
    if (std::unique_ptr<char, decltype(&std::free)> real{::realpath(path.c_str(), nullptr),
                                                         &std::free}) {
      target_ = real.get();
    }
    struct stat found {};
    mode_t mode = 0;
    if (::stat(target_.c_str(), &found) == 0) {
      if (S_ISDIR(found.st_mode)) return cannot("write", shown_, EISDIR);
      if (::access(target_.c_str(), W_OK) != 0) return cannot("write", shown_, errno);
      existed_ = true;
      if (!S_ISREG(found.st_mode)) {
        descriptor_ = ::open(target_.c_str(), O_WRONLY | O_CLOEXEC);
        if (descriptor_ < 0) return cannot("open", shown_, errno);
        return ok();
      }
      mode = found.st_mode & 07777;
    }
    const std::string folder = folder_of(target_);
    for (int attempt = 0; attempt < 1000; ++attempt) {
      // Not made from the target's name, which may already be as long as a name can be.
      temporary_ = folder + "/.diesink-" + std::to_string(::getpid()) + "-" +
                   std::to_string(next_number.fetch_add(1)) + ".tmp";
      // Registered before it exists, so that no moment is left in which an interrupt would miss it.
      slot_ = take_slot(temporary_);
      descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (descriptor_ >= 0) break;
      const int reason = errno;
      free_slot(slot_);
      slot_ = kNoSlot;
      temporary_.clear();
      if (reason != EEXIST) return cannot("create", shown_, reason);
    }
    if (descriptor_ < 0) return cannot("create", shown_, EEXIST);
    if (existed_ && ::fchmod(descriptor_, mode) != 0) return cannot("keep the mode", shown_, errno);
    return ok();
  }

  Status put(std::span<const std::byte> bytes) override {
    if (failed_ != 0) return cannot("write", shown_, failed_);
    while (!bytes.empty()) {
      const ssize_t done =
          ::write(descriptor_, bytes.data(), std::min<std::size_t>(bytes.size(), 1U << 30));
      if (done < 0 && errno == EINTR) continue;
      if (done <= 0) {
        failed_ = done < 0 ? errno : EIO;
        return cannot("write", shown_, failed_);
      }
      bytes = bytes.subspan(static_cast<std::size_t>(done));
      total_written.fetch_add(static_cast<std::uint64_t>(done), std::memory_order_relaxed);
    }
    return ok();
  }

  // After it the content is on the disk under the temporary name.
  Status close() {
    if (failed_ != 0) return cannot("write", shown_, failed_);
    if (descriptor_ < 0) return ok();
    if (!temporary_.empty() && ::fsync(descriptor_) != 0) failed_ = errno;
    if (::close(descriptor_) != 0 && failed_ == 0) failed_ = errno;
    descriptor_ = -1;
    if (failed_ != 0) return cannot("write", shown_, failed_);
    return ok();
  }

  // `reversible`: keeps the old file under the temporary name until settle().
  Status place(bool reversible) {
    if (temporary_.empty()) return ok();
    if (reversible && existed_ &&
        ::renameat2(AT_FDCWD, temporary_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) ==
            0) {
      exchanged_ = placed_ = true;
      return ok();
    }
    if (::rename(temporary_.c_str(), target_.c_str()) != 0)
      return cannot("put in place", shown_, errno);
    placed_ = true;
    return ok();
  }

  void take_back() {
    if (!placed_) return;
    placed_ = false;
    if (exchanged_) {
      ::renameat2(AT_FDCWD, temporary_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE);
    } else if (!existed_) {
      ::unlink(target_.c_str());
    }
  }

  void drop_temporary() {
    if (!temporary_.empty() && (!placed_ || exchanged_)) ::unlink(temporary_.c_str());
    free_slot(slot_);
    slot_ = kNoSlot;
    temporary_.clear();
  }

  [[nodiscard]] bool has_temporary() const { return !temporary_.empty(); }
  // Of files that are put in place: whether both would be the same one, however it is written.
  [[nodiscard]] bool same_place(const Sink& other) const {
    if (temporary_.empty() || other.temporary_.empty()) return false;
    if (name_of(target_) != name_of(other.target_)) return false;
    struct stat a {
    }, b{};
    return ::stat(folder_of(target_).c_str(), &a) == 0 &&
           ::stat(folder_of(other.target_).c_str(), &b) == 0 && a.st_dev == b.st_dev &&
           a.st_ino == b.st_ino;
  }
  [[nodiscard]] const std::string& shown() const { return shown_; }
  [[nodiscard]] std::string folder() const { return folder_of(target_); }

 private:
  std::string shown_, target_, temporary_;
  int descriptor_ = -1;
  int failed_ = 0;
  std::size_t slot_ = kNoSlot;
  bool existed_ = false, placed_ = false, exchanged_ = false;
};

OutputFiles::OutputFiles() = default;
OutputFiles::~OutputFiles() = default;

Result<ByteSink*> OutputFiles::open(const std::string& path) {
  auto sink = std::make_unique<Sink>();
  if (const Status opened = sink->open(path); !opened) return opened.error();
  for (const std::unique_ptr<Sink>& earlier : sinks_) {
    if (!sink->same_place(*earlier)) continue;
    return Error{
        ErrorCode::kUsage,
        "two outputs would be this one file, which was named before as '" + earlier->shown() + "'",
        {path}};
  }
  sinks_.push_back(std::move(sink));
  return static_cast<ByteSink*>(sinks_.back().get());
}

Status OutputFiles::commit() {
  Status status = ok();
  for (const std::unique_ptr<Sink>& sink : sinks_) {
    status = sink->close();
    if (!status) break;
  }
  std::size_t files = 0;
  for (const std::unique_ptr<Sink>& sink : sinks_) files += sink->has_temporary() ? 1 : 0;
  // Companions first: whoever sees the target finds what it names.
  for (std::size_t i = sinks_.size(); status && i-- > 0;) status = sinks_[i]->place(files > 1);
  if (!status) {
    for (const std::unique_ptr<Sink>& sink : sinks_) sink->take_back();
  }
  std::string last_folder;
  for (const std::unique_ptr<Sink>& sink : sinks_) {
    const bool on_disk = sink->has_temporary();
    sink->drop_temporary();
    if (!status || !on_disk || sink->folder() == last_folder) continue;
    last_folder = sink->folder();
    status = sync_folder(last_folder);
  }
  sinks_.clear();
  return status;
}

Result<ByteSink*> OutputFileSet::file(std::string_view name) {
  if (name.empty()) return files_.open(target_);
  return files_.open(folder_of(target_) + "/" + std::string(name));
}

Status write_file(const std::string& target, std::string_view content) {
  OutputFiles output;
  const Result<ByteSink*> sink = output.open(target);
  if (!sink) return sink.error();
  if (const Status put = (*sink)->put(std::as_bytes(std::span(content))); !put) return put;
  return output.commit();
}

std::uint64_t bytes_written() noexcept { return total_written.load(std::memory_order_relaxed); }

void unlink_temporaries() noexcept {
  for (std::size_t i = 0; i < kSlots; ++i) {
    if (slot_state[i].load() == Slot::kUsed) ::unlink(slot_path[i].data());
  }
}

}  // namespace diesink
