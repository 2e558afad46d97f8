// Messages of the driver from KHR_debug, kept as values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sightline::gl {

enum class DebugSeverity : std::uint8_t { kNotification, kLow, kMedium, kHigh };

struct DebugMessage {
  DebugSeverity severity = DebugSeverity::kNotification;
  bool is_error = false;  ///< the driver calls it an error or undefined behaviour
  std::string text;
};

/// Keeps the first messages since the last take() and only counts further ones, so that a mistake in a loop cannot fill
/// memory. Not synchronised: the context reports on the thread where it is current.
class DebugLog {
 public:
  static constexpr std::size_t kCapacity = 256;

  void add(DebugMessage message) {
    if (message.is_error || message.severity == DebugSeverity::kHigh) ++errors_;
    if (messages_.size() < kCapacity) {
      messages_.push_back(std::move(message));
    } else {
      ++dropped_;
    }
  }
  const std::vector<DebugMessage>& messages() const { return messages_; }
  std::size_t errors() const { return errors_; }    ///< errors and messages of high severity, including dropped ones
  std::size_t dropped() const { return dropped_; }  ///< messages that came after the log was full
  void clear() { *this = DebugLog(); }

 private:
  std::vector<DebugMessage> messages_;
  std::size_t errors_ = 0;
  std::size_t dropped_ = 0;
};

}  // namespace sightline::gl
