// Perl-compatible regular expressions over many short texts.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "sightline/core/error.h"

namespace sightline::apps {

/// A compiled expression. Letters match regardless of case. Texts are UTF-8; bytes that are none match nothing, not
/// even '.', and no match reaches across them. Any number of threads may use it, each with a Matcher of its own.
class RegularExpression {
 public:
  /// Fails where `pattern` is no expression, with the place of the error, and in builds without PCRE2.
  static core::Expected<RegularExpression> compile(std::string_view pattern);

  class Matcher {
   public:
    explicit Matcher(const RegularExpression& expression);
    Matcher(Matcher&&) noexcept;
    ~Matcher();
    enum class Answer { kNo, kYes, kTooHard };
    /// Whether the expression matches anywhere in the text. kTooHard: it took too many steps to know.
    Answer matches(std::string_view text);

   private:
    struct State;
    std::unique_ptr<State> state_;
  };

 private:
  struct Code;
  std::shared_ptr<const Code> code_;
};

}  // namespace sightline::apps
