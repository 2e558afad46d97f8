#include "sightline/importers/stl/internal/stl_text.h"

#include <array>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "sightline/importers/internal/counted_warnings.h"
#include "sightline/importers/internal/text_encoding.h"
#include "sightline/importers/internal/text_scanner.h"
#include "sightline/importers/internal/vertex_welder.h"

namespace sightline::importers::stl {
namespace {

using core::dvec3;

/// What words mean, misspelt ones included.
enum class Word : std::uint8_t {
  kSolid,
  kFacet,
  kNormal,
  kOuter,
  kLoop,
  kVertex,
  kEndLoop,
  kEndFacet,
  kEndSolid,
  kEnd,      ///< of whatever is open
  kComment,  ///< begins one
  kNumber,   ///< begins as numbers do
  kOther,
  kNone,  ///< the file's end
};

/// "end", "end_facet", "endfacets" and the like: the letter after "end" tells what ends.
Word end_word(std::string_view word) {
  std::string_view what = word.substr(3);
  while (!what.empty() && (what[0] == '_' || what[0] == '-')) what.remove_prefix(1);
  switch (what.empty() ? ' ' : core::lower_case(what[0])) {
    case 'l':
      return Word::kEndLoop;
    case 'f':
      return Word::kEndFacet;
    case 's':
      return Word::kEndSolid;
    default:
      return what.empty() ? Word::kEnd : Word::kOther;
  }
}

bool begins_comment(std::string_view word) {
  return word[0] == '#' || word[0] == ';' || word[0] == '%' || word[0] == '!' || word.starts_with("//") ||
         word.starts_with("/*");
}

Word meaning(std::string_view word) {
  constexpr std::pair<std::string_view, Word> kKeywords[] = {{"vertex", Word::kVertex}, {"facet", Word::kFacet},
                                                             {"normal", Word::kNormal}, {"outer", Word::kOuter},
                                                             {"loop", Word::kLoop},     {"solid", Word::kSolid}};
  if (word.empty()) return Word::kNone;
  if ((word[0] >= '0' && word[0] <= '9') || word[0] == '-' || word[0] == '+' || word[0] == '.') return Word::kNumber;
  for (const auto& [keyword, known] : kKeywords)
    if (is(word, keyword)) return known;
  if (is(word.substr(0, 3), "end")) return end_word(word);
  return begins_comment(word) ? Word::kComment : Word::kOther;
}

/// Line ends mean nothing but to names, comments, ends of two words and lines that are not understood.
class TextReader {
 public:
  TextReader(ImportJob& job, std::span<const std::byte> bytes) : job_(job), scanner_(bytes), decoder_(job) {
    if (!begins_with_mark(bytes)) return;
    note("a byte order mark is skipped");
    scanner_.pass(kByteOrderMark.size());
  }

  core::Expected<void> run() {
    for (std::string_view word; !(word = next()).empty();)
      if (auto done = statement(word); !done) return done;
    if (in_solid_) {
      if (auto told = unexpected("endsolid", {}); !told) return told;
      end_solid();
    }
    if (facets_ == 0 && skipped_lines_ > 0)
      if (auto told = job_.damage(0, "expected facets, found none in what is not understood"); !told) return told;
    habits_.list(job_);
    if (solids_ == 0) job_.warn(0, "no facets");
    return {};
  }

 private:
  core::Expected<void> statement(std::string_view word) {
    if (is(word, "facet")) return facet(true);
    switch (meaning(word)) {
      case Word::kSolid:
        begin_solid();
        return {};
      case Word::kOuter:
      case Word::kLoop:
        if (lost_) return {};
        put_back_ = word;
        note("a loop without a facet before it is read as one");
        return facet(false);
      case Word::kVertex:
        return lost_ ? core::Expected<void>{} : unexpected(in_solid_ ? "facet or endsolid" : "solid", word);
      case Word::kEndLoop:
      case Word::kEndFacet:
        if (!lost_) note(kStrayEnd);
        return {};
      case Word::kEnd:
      case Word::kEndSolid:
        end_of_solid(word);
        return {};
      case Word::kComment:
        skip_comment();
        return {};
      default:
        skip_line();
        return {};
    }
  }

  // --- solids

  void begin_solid() {
    if (in_solid_ && faces_ == 0) {
      note("a solid line that follows another counts alone");
    } else if (in_solid_) {
      note("an endsolid is missing before the next solid");
      end_solid();
    }
    name_ = decoder_.decode(scanner_.rest_of_line(), scanner_.offset(), scanner_.line());
    in_solid_ = true;
    lost_ = false;
  }

  void begin_solid_if_none() {
    if (in_solid_) return;
    note("facets outside a solid are read");
    name_ = {};
    in_solid_ = true;
  }

  void end_of_solid(std::string_view word) {
    const std::string_view rest = scanner_.rest_of_line();
    if (is(word, "end")) {
      const Word ended = meaning(fmt::format("end{}", rest.substr(0, rest.find_first_of(" \t"))));
      if (ended == Word::kEndLoop || ended == Word::kEndFacet) {
        if (!lost_) note(kStrayEnd);
        return;
      }
    }
    note_end(word, "endsolid");
    if (in_solid_)
      end_solid();
    else
      note("an endsolid line without a solid is ignored");
  }

  void end_solid() {
    in_solid_ = false;
    weld_pending();
    if (mesh_.corners.empty()) {
      job_.warn(scanner_.offset(), fmt::format("line {}: solid {} has no facets", scanner_.line(), shown_word(name_)));
      return;
    }
    ++solids_;
    mesh_.positions = welder_.take_positions();
    const core::NodeId node = name_.empty() ? job_.file_node() : job_.scene().add_node(job_.file_node(), name_);
    job_.add_mesh(node, mesh_, name_.empty() ? std::string_view(job_.file()) : name_, {}, {}, scanner_.offset());
    mesh_ = {};
    faces_ = 0;
  }

  // --- facets

  /// `with_normal`: at what follows the word facet; else at a loop.
  core::Expected<void> facet(bool with_normal) {
    constexpr std::size_t kFacetsBetweenProgress = 1024;
    if (facets_++ % kFacetsBetweenProgress == 0)
      if (auto asked = job_.progress(0.7 * scanner_.share()); !asked) return asked;
    lost_ = false;
    begin_solid_if_none();
    if (with_normal) skip_normal();
    for (;;) {
      open_loop();
      if (auto read = loop(); !read || lost_) return read;
      if (take("endfacet")) return {};
      if (meaning(put_back_) != Word::kOuter) return end_of_facet();
      note("each loop of a facet is read as a facet");
    }
  }

  /// A facet's normal follows from its corners, so whatever stands there does no harm.
  void skip_normal() {
    if (!take("normal")) {
      note("a facet without a normal is read");
      if (meaning(put_back_) != Word::kNumber) return;
    }
    for (int words = 0; words < 3; ++words) {
      const std::string_view word = next();
      const Word means = meaning(word);
      if (means == Word::kNumber || means == Word::kOther) continue;
      put_back_ = word;
      note("a normal of fewer than three numbers is ignored");
      return;
    }
  }

  static bool is_outer_loop(std::string_view word) {
    return is_one_of(word, {"outerloop", "outer_loop", "outer-loop"});
  }

  void open_loop() {
    bool outer = take("outer");
    if (!outer && meaning(put_back_) == Word::kNumber) {
      note("numbers after a normal's three are ignored");
      while (meaning(put_back_) == Word::kNumber) put_back_ = scanner_.word();
      outer = take("outer");
    }
    while (!outer && !is_outer_loop(put_back_) && meaning(put_back_) == Word::kOther) {
      put_back_ = {};
      skip_line();  // a colour or the like
      outer = take("outer");
    }
    const bool loop = take("loop");
    if (outer && loop) return;
    if (is_outer_loop(put_back_)) put_back_ = {};
    note("'outer loop' is missing or misspelt");
  }

  /// Reads the vertices of a loop, and its end.
  core::Expected<void> loop() {
    const std::size_t first = pending_.size();
    for (;;) {
      const std::string_view word = next();
      if (is(word, "vertex")) {
        if (auto read = vertex(); !read || lost_) return dropped(first, read);
        continue;
      }
      if (is(word, "endloop")) break;
      const Word means = meaning(word);
      if (means == Word::kComment) {
        skip_comment();
      } else if (means == Word::kNumber && pending_.size() > first) {
        note("numbers after a vertex's three are ignored");
        scanner_.rest_of_line();
      } else if (ends_loop(means, pending_.size() - first)) {
        end_loop(word, means);
        break;
      } else {
        return dropped(first, unexpected("vertex or endloop", word));
      }
    }
    add_face(first);
    return {};
  }

  core::Expected<void> vertex() {
    dvec3 corner;
    for (glm::length_t k = 0; k < 3; ++k)
      if (scanner_.number(corner[k]) != TextScanner::Found::kNumber) {
        lost_ = true;
        return damage("three numbers after vertex", "something else");
      }
    pending_.push_back(corner);
    return {};
  }

  /// Where a facet begins with the loop before still open, its vertices may not have been all.
  static bool ends_loop(Word means, std::size_t corners) {
    return means == Word::kEndLoop || means == Word::kEnd || means == Word::kEndFacet ||
           (means == Word::kFacet && corners == 3);
  }

  void end_loop(std::string_view word, Word means) {
    if (means == Word::kEnd) return end_in_two_words("loop");
    if (means == Word::kEndLoop) return note_end(word, "endloop");
    note("an endloop is missing");
    put_back_ = word;
  }

  /// Forgets the corners of a facet that cannot be read.
  core::Expected<void> dropped(std::size_t first, core::Expected<void> outcome) {
    pending_.resize(first);
    return outcome;
  }

  void add_face(std::size_t first) {
    const std::size_t corners = pending_.size() - first;
    if (corners < 3) {
      note("a facet of fewer than three vertices is left out");
      pending_.resize(first);
      return;
    }
    if (corners > 3) note("a facet of more than three vertices becomes triangles");
    std::vector<std::uint32_t>& sizes = mesh_.face_sizes;
    if (corners > 3 && sizes.empty()) sizes.assign(faces_, 3);
    if (corners > 3 || !sizes.empty()) sizes.push_back(std::uint32_t(corners));
    ++faces_;
    if (pending_.size() >= VertexWelder::kBlock) weld_pending();
  }

  void weld_pending() {
    welder_.add(pending_, mesh_.corners);
    pending_.clear();
  }

  /// What ends a facet where 'endfacet' does not.
  core::Expected<void> end_of_facet() {
    std::string_view word = next();
    for (; meaning(word) == Word::kOther; word = next()) skip_line();
    const Word means = meaning(word);
    if (means == Word::kNone) return unexpected("endfacet", word);
    if (means == Word::kEnd) {
      end_in_two_words("facet");
    } else if (means == Word::kEndFacet) {
      note_end(word, "endfacet");
    } else {
      note("an endfacet is missing");
      put_back_ = word;
    }
    return {};
  }

  // --- words

  std::string_view next() { return put_back_.empty() ? scanner_.word() : std::exchange(put_back_, {}); }

  /// Takes the next word if it is that keyword, else puts it back.
  bool take(std::string_view keyword) {
    for (;;) {
      const std::string_view word = next();
      if (is(word, keyword)) return true;
      if (word.empty() || !begins_comment(word)) {
        put_back_ = word;
        return false;
      }
      skip_comment();
    }
  }

  void end_in_two_words(std::string_view what) {
    note_end("end", what);
    const std::string_view word = scanner_.word_in_line();
    if (!is(word, what)) put_back_ = word;
  }

  void skip_comment() {
    note("comments are skipped");
    scanner_.rest_of_line();
  }
  void skip_line() {
    if (!lost_) note("a line that is not understood is skipped");
    ++skipped_lines_;
    scanner_.rest_of_line();
  }

  void note(std::string_view what) {
    habits_.add(what, scanner_.offset(), [&] { return fmt::format("line {}", scanner_.line()); });
  }
  void note_end(std::string_view word, std::string_view keyword) {
    if (!is(word, keyword)) note("an end that is misspelt or in two words is understood");
  }

  /// Reports damage. When lenient, words up to the next facet or solid are ignored from here on.
  core::Expected<void> unexpected(std::string_view expected, std::string_view found) {
    lost_ = true;
    put_back_ = found;
    return damage(expected, found.empty() ? "the file's end" : shown_word(found));
  }
  core::Expected<void> damage(std::string_view expected, std::string_view found) {
    return job_.damage(scanner_.offset(),
                       fmt::format("line {}: expected {}, found {}", scanner_.line(), expected, found));
  }

  static constexpr std::string_view kStrayEnd = "an end of what had not begun is ignored";

  ImportJob& job_;
  TextScanner scanner_;
  CountedWarnings habits_;
  std::string_view put_back_;
  bool in_solid_ = false;
  bool lost_ = false;  // after damage, until something begins
  NameDecoder decoder_;
  std::string name_;
  std::uint64_t facets_ = 0, solids_ = 0, skipped_lines_ = 0;  // of the file
  std::size_t faces_ = 0;                                      // of the solid
  std::vector<dvec3> pending_;                                 // corners of whole facets
  VertexWelder welder_;
  PolygonMesh mesh_;
};

}  // namespace

core::Expected<void> read_text(ImportJob& job, std::span<const std::byte> bytes) {
  return TextReader(job, bytes).run();
}

}  // namespace sightline::importers::stl
