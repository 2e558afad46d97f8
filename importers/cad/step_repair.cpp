#include "sightline/importers/cad/internal/step_repair.h"

#include <algorithm>
#include <cstdint>
#include <optional>

#include <fmt/format.h>

#include "sightline/core/internal/ascii_case.h"
#include "sightline/importers/internal/text_encoding.h"
#include "sightline/importers/internal/text_scanner.h"

namespace sightline::importers {
namespace {

bool is_ascii(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; });
}

/// Takes the first character off a text of valid UTF-8.
char32_t take_character(std::string_view& text) {
  const auto first = static_cast<unsigned char>(text[0]);
  const std::size_t length = utf8_length(text);
  char32_t c = length == 1 ? first : first & (0x7fu >> length);
  for (std::size_t i = 1; i < length; ++i) c = c << 6 | (static_cast<unsigned char>(text[i]) & 0x3f);
  text.remove_prefix(length);
  return c;
}

/// Each run of characters beyond ASCII becomes "\X2\...\X0\", in UTF-16.
std::string with_escapes(std::string_view utf8) {
  std::string escaped;
  std::size_t backslashes = 0;  // directly before
  bool within = false;
  while (!utf8.empty()) {
    const char32_t c = take_character(utf8);
    if (c < 0x80) {
      if (within) escaped += "\\X0\\";
      within = false;
      escaped += char(c);
      backslashes = c == '\\' ? backslashes + 1 : 0;
      continue;
    }
    if (!within && backslashes % 2 == 1) escaped += '\\';  // a lone one would swallow that of the escape
    if (!within) escaped += "\\X2\\";
    within = true;
    backslashes = 0;
    if (c >= 0x10000)
      escaped += fmt::format("{:04X}{:04X}", 0xd800 + ((std::uint32_t(c) - 0x10000) >> 10), 0xdc00 + (c & 0x3ff));
    else
      escaped += fmt::format("{:04X}", std::uint32_t(c));
  }
  return within ? escaped + "\\X0\\" : escaped;
}

class StepRepair {
 public:
  StepRepair(ImportJob& job, std::string_view text) : job_(job), text_(text), names_(job) { out_.reserve(text.size()); }

  std::string run() {
    while (!ended_ && pass_blanks()) next();
    if (elsewhere_ > 0) job_.warn(0, fmt::format("{} references to entities of other files are not read", elsewhere_));
    return std::move(out_);
  }

 private:
  /// Passes white space and comments; false at the end.
  bool pass_blanks() {
    while (at_ < text_.size()) {
      if (is_space(text_[at_]))
        out_ += text_[at_++];
      else if (text_.substr(at_).starts_with("/*"))
        pass_comment();
      else
        return true;
    }
    return false;
  }

  /// One that never ends reaches to the end of the file.
  void pass_comment() {
    const std::size_t end = text_.find("*/", at_ + 2);
    at_ = end == text_.npos ? text_.size() : end + 2;
    out_ += ' ';
  }

  bool at_keyword(std::string_view keyword) const {
    const std::string_view here = text_.substr(at_, keyword.size());
    const char after = at_ + keyword.size() < text_.size() ? text_[at_ + keyword.size()] : ';';
    return core::same_but_for_case(here, keyword) && (is_space(after) || after == ';' || after == '(' || after == '/');
  }

  /// A statement, or a section that is left out.
  void next() {
    const std::size_t begin = out_.size();
    if (text_[at_] == '#') return copy_statement();
    if (at_keyword("ANCHOR") || at_keyword("REFERENCE")) return pass_section();
    if (at_keyword("DATA")) {
      copy_statement();
      out_.resize(end_of_data_.value_or(begin));
      if (!end_of_data_) out_ += "DATA;";
      in_data_ = true;
      return;
    }
    if (at_keyword("ENDSEC") && in_data_) {
      end_of_data_ = begin;
      in_data_ = false;
    }
    ended_ = at_keyword("END-ISO-10303-21");  // only signatures follow
    const bool signature = at_keyword("SIGNATURE");
    copy_statement();
    if (signature) out_.resize(begin);
  }

  void pass_section() {
    const std::size_t begin = out_.size();
    for (bool last = false; !last && pass_blanks();) {
      last = at_keyword("ENDSEC");
      const std::size_t statement = out_.size();
      copy_statement();
      // "#12=<part.stp#top>;" but not "#12=<#top>;"
      const std::string_view copied = std::string_view(out_).substr(statement);
      const std::size_t target = copied.find('<');
      elsewhere_ += copied.starts_with('#') && target != copied.npos && copied.substr(target + 1, 1) != "#" ? 1 : 0;
    }
    out_.resize(begin);
  }

  /// Up to and with the next semicolon.
  void copy_statement() {
    while (at_ < text_.size()) {
      const std::size_t end = std::min(text_.find_first_of("';/", at_), text_.size());
      out_.append(text_, at_, end - at_);
      at_ = end;
      if (at_ == text_.size()) return;
      if (text_[at_] == '\'') {
        copy_string();
      } else if (text_.substr(at_).starts_with("/*")) {
        pass_comment();
      } else {
        out_ += text_[at_];
        if (text_[at_++] == ';') return;
      }
    }
  }

  void copy_string() {
    const std::size_t begin = at_ + 1;
    std::size_t end = text_.find('\'', begin);
    while (end != text_.npos && text_.substr(end + 1, 1) == "'") end = text_.find('\'', end + 2);
    const std::string_view content = text_.substr(begin, end == text_.npos ? end : end - begin);
    out_ += '\'';
    out_ += is_ascii(content) ? std::string(content) : with_escapes(names_.decode(content, begin));
    if (end != text_.npos) out_ += '\'';
    at_ = end == text_.npos ? text_.size() : end + 1;
  }

  ImportJob& job_;
  std::string_view text_;
  NameDecoder names_;
  std::string out_;
  std::size_t at_ = 0;
  std::optional<std::size_t> end_of_data_;  // where the latest DATA section ends in `out_`
  bool in_data_ = false, ended_ = false;
  std::uint64_t elsewhere_ = 0;
};

}  // namespace

std::string repaired_step(ImportJob& job, std::string_view text) {
  return StepRepair(job, text).run();
}

}  // namespace sightline::importers
