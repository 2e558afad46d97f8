#include "sightline/importers/rvm/internal/rvm_text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "sightline/core/primitive.h"
#include "sightline/importers/internal/file_bytes.h"
#include "sightline/importers/internal/text_scanner.h"
#include "sightline/importers/rvm/internal/rvm_output.h"

namespace sightline::importers {
namespace {

constexpr std::size_t kMatrixNumbers = 12, kBoxNumbers = 6;

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

std::string_view text_of(std::span<const std::byte> bytes) {
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  return text;
}

/// The lines of a text, one after the other. They end with a line feed, or with a return alone where there is none.
class Lines {
 public:
  Lines(std::string_view text, std::uint64_t skipped)
      : text_(text), skipped_(skipped), end_of_line_(text.find('\n') == text.npos ? '\r' : '\n') {
    find_end();
  }
  bool at_end() const { return begin_ >= text_.size(); }
  std::string_view line() const { return text_.substr(begin_, end_ - begin_); }
  std::uint64_t number() const { return number_; }
  std::uint64_t offset() const { return skipped_ + begin_; }
  void next() {
    begin_ = end_ + 1;
    ++number_;
    if (!at_end()) find_end();
  }

 private:
  void find_end() { end_ = std::min(text_.find(end_of_line_, begin_), text_.size()); }
  std::string_view text_;
  std::uint64_t skipped_;
  char end_of_line_;
  std::size_t begin_ = 0, end_ = 0;
  std::uint64_t number_ = 1;
};

/// A whole number that a count or an index can be; kNone: none.
std::uint32_t whole(double value) {
  return value >= 0.0 && value < double(core::kNone) && value == std::floor(value) ? std::uint32_t(value) : core::kNone;
}

/// The numbers between a chunk's tag and the next.
struct Numbers {
  std::vector<double> values;
  std::array<std::size_t, 2> in_lines{};  // of the first two lines that hold any
  std::string stop;                       // what ended them, when it was no tag
  std::size_t size() const { return values.size(); }
  double at(std::size_t i) const { return values[i]; }
};

class Transcription {
 public:
  Transcription(ImportJob& job, std::string_view text, std::uint64_t skipped)
      : job_(job), lines_(text, skipped), size_(double(text.size())), writer_(sink_) {}

  core::Expected<RvmImage> run() {
    // The binary form is at least as strict about what comes first.
    while (!lines_.at_end() && trimmed(lines_.line()).empty()) lines_.next();
    bool ended = false;
    while (!lines_.at_end() && !ended) {
      if (auto asked = job_.progress(0.5 * double(lines_.offset()) / size_); !asked)
        return tl::unexpected(asked.error());
      const std::string_view tag = trimmed(lines_.line());
      if (tag.empty()) {
        lines_.next();
        continue;
      }
      begin_line_ = lines_.number(), begin_offset_ = lines_.offset();
      error_.clear();
      if (rvm::is_known_tag(tag)) {
        lines_.next();
        ended = tag == "END:";
        read_chunk(tag);
      } else {
        refuse(fmt::format("expected a chunk's tag, found \"{}\"", shown(tag)));
      }
      if (error_.empty()) continue;
      if (auto asked = job_.damage(begin_offset_, fmt::format("line {}: {}", begin_line_, error_)); !asked)
        return tl::unexpected(asked.error());
      if (tag == "CNTB") write_group({}, {}, 1, 0);  // keeps the nesting right
      if (!rvm::is_known_tag(tag)) lines_.next();
      while (!lines_.at_end() && !rvm::is_known_tag(trimmed(lines_.line()))) lines_.next();
    }
    if (ended) {
      begin("END:");
      writer_.u32(1);
      writer_.end();
    }
    if (!writer_.ok()) return core::fail(fmt::format("{}: holds more than 4 GiB in binary form", job_.file()));
    return RvmImage{std::move(sink_.bytes), std::move(places_)};
  }

 private:
  static std::string shown(std::string_view text) {
    std::string line(text.substr(0, 40));
    for (char& c : line)
      if (c < ' ' || c > '~') c = '?';
    return line;
  }
  void refuse(std::string message) {
    if (error_.empty()) error_ = std::move(message);
  }

  // --- what chunks are made of -------------------------------------------------------------------------------------

  /// The two numbers behind each tag; returns the second, the version.
  std::uint32_t version(std::string_view tag) {
    Numbers found;
    if (!lines_.at_end() && read_numbers(lines_.line(), found) && found.size() == 2) {
      lines_.next();
      return whole(found.at(1));
    }
    if (tag != "END:") refuse(fmt::format("{} chunk: expected two numbers on the line behind the tag", tag));
    return 1;
  }

  std::string_view string(std::string_view tag, std::string_view what) {
    if (lines_.at_end()) {
      refuse(fmt::format("{} chunk: expected the line of its {}, found the end of the file", tag, what));
      return {};
    }
    const std::string_view text = trimmed(lines_.line());
    lines_.next();
    return text;
  }

  /// Numbers of one line; false when it holds anything else.
  static bool read_numbers(std::string_view line, Numbers& to) {
    const char *at = line.data(), *const end = at + line.size();
    for (;;) {
      while (at != end && is_blank(*at)) ++at;
      if (at == end) return true;
      if (*at == '+') ++at;
      double value = 0.0;
      const auto [stop, error] = std::from_chars(at, end, value);
      if (error == std::errc::invalid_argument) return false;
      if (error == std::errc::result_out_of_range) value = *at == '-' ? -INFINITY : INFINITY;
      if (stop != end && !is_blank(*stop) && *stop != '-' && *stop != '+') return false;
      to.values.push_back(value);
      at = stop;
    }
  }

  /// All numbers up to the next tag, or to a line that holds anything else.
  Numbers numbers() {
    Numbers found;
    for (std::size_t filled = 0; !lines_.at_end(); lines_.next()) {
      const std::string_view line = trimmed(lines_.line());
      if (rvm::is_known_tag(line)) break;
      const std::size_t before = found.size();
      if (!read_numbers(line, found)) {
        found.values.resize(before);
        found.stop = fmt::format(" before line {}: \"{}\"", lines_.number(), shown(line));
        break;
      }
      if (filled < 2 && found.size() > before) found.in_lines[filled++] = found.size() - before;
    }
    return found;
  }

  // --- chunks ------------------------------------------------------------------------------------------------------

  void begin(std::string_view tag) {
    places_.push_back({sink_.bytes.size(), begin_offset_, begin_line_});
    writer_.begin(tag);
  }

  void read_chunk(std::string_view tag) {
    const std::uint32_t number = version(tag);
    if (!error_.empty()) return;
    if (tag == "HEAD") return read_head(number);
    if (tag == "MODL") return read_model();
    if (tag == "CNTB") return read_group();
    if (tag == "COLR") return read_colour();
    if (tag == "CNTE") {
      begin(tag);
      writer_.u32(1);
      return writer_.end();
    }
    if (tag != "END:") read_item(tag);
  }

  void read_head(std::uint32_t number) {
    std::array<std::string_view, 4> strings;
    for (auto& text : strings) text = string("HEAD", "strings");
    const bool encoded = number >= 2 && !lines_.at_end() && trimmed(lines_.line()) != "MODL";
    const std::string_view encoding = encoded ? string("HEAD", "encoding") : std::string_view();
    if (!error_.empty()) return;
    begin("HEAD");
    writer_.u32(2);
    for (const std::string_view text : strings) writer_.string(text);
    writer_.string(encoding);
    writer_.end();
  }

  void read_model() {
    const std::string_view project = string("MODL", "project"), name = string("MODL", "name");
    if (!error_.empty()) return;
    begin("MODL");
    writer_.u32(1);
    writer_.string(project);
    writer_.string(name);
    writer_.end();
  }

  void read_group() {
    const std::string_view name = string("CNTB", "name");
    const Numbers found = numbers();
    if (!error_.empty()) return;
    const std::uint32_t colour = found.size() > 3 ? whole(found.at(3)) : core::kNone;
    if (colour == core::kNone)
      return refuse(fmt::format("CNTB chunk: expected a reference point and a colour index, found {} numbers{}",
                                found.size(), found.stop));
    write_group(name, found.values, colour, found.size() > 4 ? found.at(4) : 0.0);
  }

  void write_group(std::string_view name, std::span<const double> point, std::uint32_t colour, double transparency) {
    begin("CNTB");
    writer_.u32(3);
    writer_.string(name);
    for (std::size_t i = 0; i < 3; ++i) writer_.f32(i < point.size() ? float(point[i]) : 0.0f);
    writer_.u32(colour);
    writer_.u32(transparency_word(transparency));
    writer_.end();
  }

  void read_colour() {
    const Numbers found = numbers();
    if (!error_.empty()) return;
    bool good = found.size() == 4;
    for (std::size_t i = 0; good && i < 4; ++i) good = whole(found.at(i)) <= (i == 0 ? core::kNone - 1 : 255u);
    if (!good) return refuse("COLR chunk: expected an index and red, green, blue from 0 to 255" + found.stop);
    begin("COLR");
    writer_.u32(1);
    writer_.u32(whole(found.at(0)));
    writer_.u32(whole(found.at(1)) << 24 | whole(found.at(2)) << 16 | whole(found.at(3)) << 8);
    writer_.end();
  }

  /// Per cent, or the binary form's word.
  static std::uint32_t transparency_word(double value) {
    const std::uint32_t word = whole(value);
    if (word == core::kNone) return 0;
    return word <= rvm::kMaxTransparency ? word << 24 : word;
  }

  void read_item(std::string_view tag) {
    const Numbers found = numbers();
    if (!error_.empty()) return;
    const std::uint32_t kind = found.size() > 0 ? whole(found.at(0)) : core::kNone;
    if (kind < 1 || kind > rvm::kFacetGroupKind)
      return refuse(
          fmt::format("{} chunk: expected a primitive kind 1 to {}{}", tag, rvm::kFacetGroupKind, found.stop));
    // The kind, then a transparency or none, the matrix, a transparency or none, the box, and one or none.
    const bool plain = tag == "PRIM";
    if (const std::size_t needed = 1 + kMatrixNumbers + kBoxNumbers + least_parameters(kind); found.size() < needed)
      return refuse(fmt::format("{} chunk: expected {}{} numbers, found {}{}", tag,
                                kind == rvm::kFacetGroupKind ? "at least " : "", needed, found.size(), found.stop));
    struct NumberLayout {
      std::size_t matrix, box, parameters, extra;
    };
    constexpr std::size_t kNo = 0;
    const NumberLayout without{1, 1 + kMatrixNumbers, 1 + kMatrixNumbers + kBoxNumbers, kNo},
        first{2, 2 + kMatrixNumbers, 2 + kMatrixNumbers + kBoxNumbers, 1},
        last{1, 1 + kMatrixNumbers, 2 + kMatrixNumbers + kBoxNumbers, 1 + kMatrixNumbers + kBoxNumbers};
    // Rows of the matrix have four numbers, a transparency is alone on its line.
    const bool alone = found.in_lines[0] == 1 && found.in_lines[1] == 1;
    for (const NumberLayout& layout : {without, alone ? first : last}) {
      if (layout.extra != kNo && plain) break;
      if (!fits(found, layout.parameters, kind)) continue;
      begin(tag);
      writer_.u32(1);
      writer_.u32(kind);
      for (std::size_t column = 0; column < 4; ++column)
        for (std::size_t row = 0; row < 3; ++row) writer_.f32(float(found.at(layout.matrix + 4 * row + column)));
      for (std::size_t i = 0; i < kBoxNumbers; ++i) writer_.f32(float(found.at(layout.box + i)));
      if (!plain) writer_.u32(layout.extra == kNo ? 0 : transparency_word(found.at(layout.extra)));
      write_parameters(found, layout.parameters, kind);
      return writer_.end();
    }
    refuse(fmt::format("{} chunk: expected {}, found {} numbers{}", tag,
                       kind == rvm::kFacetGroupKind
                           ? "as many vertices as its counts say"
                           : fmt::format("{}", 1 + kMatrixNumbers + kBoxNumbers + least_parameters(kind)),
                       found.size(), found.stop));
  }

  static std::size_t least_parameters(std::uint32_t kind) {
    return kind == rvm::kFacetGroupKind ? 1 : std::size_t(core::parameter_count(core::Kind(kind - 1)));
  }

  /// Whether the numbers from `at` on are those of the kind, to the last.
  static bool fits(const Numbers& found, std::size_t at, std::uint32_t kind) {
    if (kind != rvm::kFacetGroupKind) return found.size() == at + least_parameters(kind);
    bool good = true;
    walk_facets(
        found, at, [](std::uint32_t) {}, [](double) {}, good);
    return good;
  }

  static void walk_facets(const Numbers& found, std::size_t at, auto&& count, auto&& number, bool& good) {
    constexpr std::size_t kNumbersPerVertex = 6;
    const auto take = [&]() -> std::uint32_t {
      const std::uint32_t value = at < found.size() ? whole(found.at(at)) : core::kNone;
      // Whatever is counted takes a number at least.
      good = good && value != core::kNone && value <= found.size() - at;
      ++at;
      if (good) count(value);
      return good ? value : 0;
    };
    const std::uint32_t polygons = take();
    for (std::uint32_t p = 0; p < polygons && good; ++p) {
      const std::uint32_t contours = take();
      for (std::uint32_t c = 0; c < contours && good; ++c) {
        const std::uint32_t vertices = take();
        good = good && kNumbersPerVertex * vertices <= found.size() - std::min(at, found.size());
        for (std::size_t i = 0; good && i < kNumbersPerVertex * vertices; ++i) number(found.at(at++));
      }
    }
    good = good && at == found.size();
  }

  void write_parameters(const Numbers& found, std::size_t at, std::uint32_t kind) {
    if (kind != rvm::kFacetGroupKind) {
      for (; at < found.size(); ++at) writer_.f32(float(found.at(at)));
      return;
    }
    bool good = true;
    walk_facets(
        found, at, [&](std::uint32_t n) { writer_.u32(n); }, [&](double value) { writer_.f32(float(value)); }, good);
  }

  ImportJob& job_;
  Lines lines_;
  double size_;
  VectorSink sink_;
  rvm::ChunkWriter writer_;
  std::vector<RvmTextPlace> places_;
  std::uint64_t begin_line_ = 1, begin_offset_ = 0;
  std::string error_;
};

}  // namespace

bool is_rvm_text(std::span<const std::byte> bytes) {
  std::string_view text = text_of(bytes);
  while (!text.empty() && (is_blank(text.front()) || text.front() == '\n')) text.remove_prefix(1);
  return text.starts_with("HEAD");
}

core::Expected<RvmImage> image_of_rvm_text(ImportJob& job, std::span<const std::byte> bytes) {
  const std::string_view text = text_of(bytes);
  return Transcription(job, text, bytes.size() - text.size()).run();
}

}  // namespace sightline::importers
