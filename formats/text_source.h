// Text that comes in blocks, so that a long file need not be held.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "core/result.h"

namespace diesink {

class TextSource {
 public:
  virtual ~TextSource() = default;
  // The next block, of any length; empty at the end. Valid until the next call.
  virtual std::string_view next() = 0;
  // Back to the beginning.
  virtual void rewind() = 0;
  // What went wrong reading, if anything: then the text ended early.
  [[nodiscard]] virtual Status status() const { return ok(); }
};

// A text in memory, which must outlive this.
class HeldText final : public TextSource {
 public:
  explicit HeldText(std::string_view text) : text_(text) {}
  std::string_view next() override {
    const std::string_view all = given_ ? std::string_view{} : text_;
    given_ = true;
    return all;
  }
  void rewind() override { given_ = false; }

 private:
  std::string_view text_;
  bool given_ = false;
};

// A regular file, block by block. Errors: kInput where it cannot be opened, or is no regular file
// (a pipe cannot be gone over twice: read_file holds it).
Result<std::unique_ptr<TextSource>> open_text(const std::string& path);

}  // namespace diesink
