// The line that tells the user what has happened.
#pragma once

#include <string>
#include <utility>

#include "sightline/core/error.h"

namespace sightline::apps {

/// What becomes of an action.
using Done = core::Expected<void>;

class Messages {
 public:
  void tell(std::string text, bool error = false) {
    text_ = std::move(text);
    is_error_ = error;
    is_new_ = true;
  }
  /// What became of an action. An error stays until the next action succeeds.
  void tell_outcome(const Done& done) {
    if (!done)
      tell(done.error().message, true);
    else if (is_error_ && !is_new_)
      tell("");
  }
  const std::string& text() const { return text_; }
  bool is_error() const { return is_error_; }
  /// Whether something was told since the last frame.
  bool is_new() const { return is_new_; }
  void end_frame() { is_new_ = false; }

 private:
  std::string text_;
  bool is_error_ = false, is_new_ = false;
};

}  // namespace sightline::apps
