// Variables of the environment for the time of a test.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "sightline/core/internal/platform/environment.h"

namespace sightline::tests {

/// Keeps a variable's value, and restores it at its end. Values are for this process and those that it starts.
class Variable {
 public:
  explicit Variable(std::string name) : name_(std::move(name)), before_(core::platform::environment(name_.c_str())) {}
  Variable(std::string name, const std::optional<std::string>& value) : Variable(std::move(name)) { set(value); }
  ~Variable() { set(before_); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;
  /// No value: removes it.
  void set(const std::optional<std::string>& value) const { core::platform::set_environment(name_.c_str(), value); }

 private:
  std::string name_;
  std::optional<std::string> before_;
};

}  // namespace sightline::tests
