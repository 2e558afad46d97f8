// The mark-ups of what the viewer shows now, and how points of the image make one.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "sightline/apps/viewpoints/markup.h"
#include "sightline/core/error.h"
#include "sightline/core/view.h"

namespace sightline::apps {

class Marking {
 public:
  Markup::Kind kind = Markup::Kind::kArrow;  ///< what is drawn next

  /// The words of the one that was drawn last, while somebody writes them, or of the one that is drawn next.
  std::string& words() { return writing_ ? list_.back().words : words_; }
  const std::string& next_words() const { return words_; }

  const std::vector<Markup>& list() const { return list_; }
  void set(std::vector<Markup> list) {
    writing_ = asks_ = false;
    list_ = std::move(list);
  }
  void add(Markup markup) { list_.push_back(std::move(markup)); }
  void remove(std::size_t index) {
    end_writing();
    if (index < list_.size()) list_.erase(list_.begin() + std::ptrdiff_t(index));
  }
  void clear() { set({}); }
  /// One that is drawn by hand gets the words that wait for it; without any, somebody may write them from now on.
  void draw(Markup markup, bool write) {
    end_writing();
    markup.words = std::exchange(words_, "");
    writing_ = asks_ = write && markup.words.empty();
    add(std::move(markup));
  }
  /// Once after draw(): the field for words wants the keyboard.
  bool asks_for_words() { return std::exchange(asks_, false); }
  /// A text without words is gone then.
  void end_writing() {
    if (std::exchange(writing_, false) && list_.back().kind == Markup::Kind::kText && list_.back().words.empty())
      list_.pop_back();
  }

 private:
  std::vector<Markup> list_;
  std::string words_;
  bool writing_ = false, asks_ = false;
};

/// The direction in which an image looks, through its middle.
core::dvec3 direction_of(const core::View& view);

/// An image and a plane parallel to it, on which mark-ups lie.
struct MarkupPlane {
  core::View view;
  std::array<int, 2> size{};  ///< of the image, pixels
  core::dvec3 through{0.0};   ///< a point of the plane

  /// The point below a pixel, from the image's upper left corner. Fails where the plane is not before the eye there.
  core::Expected<core::dvec3> at(const core::dvec2& pixel) const;
};

/// The mark-up that a drag makes: an arrow has its tip where the drag begins, a cloud lies between both ends, with its
/// first corner on the upper left; a text lies at the beginning. Fails where a text has no words, and as
/// MarkupPlane::at() does.
core::Expected<Markup> drawn_markup(Markup::Kind kind, const std::string& words, const MarkupPlane& plane,
                                    const core::dvec2& from, const core::dvec2& to);

/// A script's "arrow X Y X Y [words]", "cloud X Y X Y [words]" or "text X Y words", in pixels of the window.
struct AskedMarkup {
  Markup::Kind kind = Markup::Kind::kArrow;
  core::dvec2 from{0.0}, to{0.0};  ///< equal for texts
  std::string words;
};
core::Expected<AskedMarkup> parse_markup(const std::string& text);

}  // namespace sightline::apps
