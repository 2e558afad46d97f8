#include "sightline/apps/view/regular_expression.h"

#if SIGHTLINE_HAS_PCRE2

#define PCRE2_CODE_UNIT_WIDTH 8
#include <pcre2.h>

namespace sightline::apps {
namespace {

/// One text may take so many steps, some milliseconds: nested repeats would take years on a text of 30 letters.
constexpr std::uint32_t kMostMatchSteps = 1'000'000;
constexpr std::size_t kStackBytes = 32 << 10, kLargestStackBytes = 1 << 20;  // of compiled code

struct Free {
  void operator()(pcre2_code* p) const { pcre2_code_free(p); }
  void operator()(pcre2_match_data* p) const { pcre2_match_data_free(p); }
  void operator()(pcre2_match_context* p) const { pcre2_match_context_free(p); }
  void operator()(pcre2_jit_stack* p) const { pcre2_jit_stack_free(p); }
};
template <class T>
using Owned = std::unique_ptr<T, Free>;

}  // namespace

struct RegularExpression::Code {
  Owned<pcre2_code> code;
  bool compiled_to_machine_code;
};

struct RegularExpression::Matcher::State {
  std::shared_ptr<const Code> code;
  Owned<pcre2_match_data> data;
  Owned<pcre2_match_context> context;
  Owned<pcre2_jit_stack> stack;
};

core::Expected<RegularExpression> RegularExpression::compile(std::string_view pattern) {
  constexpr std::uint32_t kOptions = PCRE2_CASELESS | PCRE2_UTF | PCRE2_MATCH_INVALID_UTF | PCRE2_NEVER_BACKSLASH_C;
  int error = 0;
  PCRE2_SIZE at = 0;
  Owned<pcre2_code> code(pcre2_compile(PCRE2_SPTR(pattern.data()), pattern.size(), kOptions, &error, &at, nullptr));
  if (!code) {
    PCRE2_UCHAR message[256];
    pcre2_get_error_message(error, message, sizeof message);
    return core::fail("regular expression, after byte " + std::to_string(at) + ": " +
                      reinterpret_cast<const char*>(message));
  }
  const bool fast = pcre2_jit_compile(code.get(), PCRE2_JIT_COMPLETE) == 0;
  RegularExpression expression;
  expression.code_ = std::make_shared<const Code>(Code{std::move(code), fast});
  return expression;
}

RegularExpression::Matcher::Matcher(const RegularExpression& expression) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.code = expression.code_;
  s.data.reset(pcre2_match_data_create(1, nullptr));
  s.context.reset(pcre2_match_context_create(nullptr));
  s.stack.reset(pcre2_jit_stack_create(kStackBytes, kLargestStackBytes, nullptr));
  pcre2_set_match_limit(s.context.get(), kMostMatchSteps);
  pcre2_jit_stack_assign(s.context.get(), nullptr, s.stack.get());
}

RegularExpression::Matcher::Answer RegularExpression::Matcher::matches(std::string_view text) {
  State& s = *state_;
  const pcre2_code* code = s.code->code.get();
  const auto subject = PCRE2_SPTR(text.data());
  int result = PCRE2_ERROR_JIT_STACKLIMIT;
  if (s.code->compiled_to_machine_code)
    result = pcre2_jit_match(code, subject, text.size(), 0, 0, s.data.get(), s.context.get());
  if (result == PCRE2_ERROR_JIT_STACKLIMIT)  // the interpreter is slower, but has its stack on the heap
    result = pcre2_match(code, subject, text.size(), 0, PCRE2_NO_JIT, s.data.get(), s.context.get());
  return result >= 0 ? Answer::kYes : result == PCRE2_ERROR_NOMATCH ? Answer::kNo : Answer::kTooHard;
}

}  // namespace sightline::apps

#else

namespace sightline::apps {

struct RegularExpression::Code {};
struct RegularExpression::Matcher::State {};

core::Expected<RegularExpression> RegularExpression::compile(std::string_view) {
  return core::fail("regular expressions: this build is without PCRE2");
}
RegularExpression::Matcher::Matcher(const RegularExpression&) {}
RegularExpression::Matcher::Answer RegularExpression::Matcher::matches(std::string_view) {
  return Answer::kNo;
}

}  // namespace sightline::apps

#endif

namespace sightline::apps {

RegularExpression::Matcher::Matcher(Matcher&&) noexcept = default;
RegularExpression::Matcher::~Matcher() = default;

}  // namespace sightline::apps
