// Texts in little room.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace sightline::apps {

/// A text as it is where it fits, or else as much of both its ends as fits beside "…": of names and paths in a list,
/// some differ where they begin ("FLANGE 1 of BRANCH /P-1"), others where they end ("/P-1/B1"). UTF-8 characters stay
/// whole. `fits` says so of a text; whatever is shorter than what fits must fit. `behind`: the share of what is kept
/// that is of the end.
template <class Fits>
std::string shortened_to(std::string_view text, const Fits& fits, double behind = 0.4) {
  if (fits(text)) return std::string(text);
  const auto whole = [&](std::size_t at) {  // the end of the character that a place lies in
    while (at < text.size() && (text[at] & 0xc0) == 0x80) ++at;
    return at;
  };
  const auto ends = [&](std::size_t kept) {
    const auto last = std::size_t(behind * double(kept));
    const std::size_t front = kept - last, back = text.size() - last;
    return std::string(text.substr(0, front == 0 ? 0 : whole(front))) + "…" + std::string(text.substr(whole(back)));
  };
  std::size_t most = 0, beyond = text.size();  // bytes that fit, and that do not
  while (most + 1 < beyond) {
    const std::size_t middle = (most + beyond) / 2;
    (fits(ends(middle)) ? most : beyond) = middle;
  }
  return ends(most);
}

/// Names below another one in a tree do without that first: "FLANGE 1 of BRANCH …" below "/P-1/B1", "…/B1" below
/// "/P-1".
template <class Fits>
std::string shortened_below(std::string_view above, std::string_view name, const Fits& fits) {
  if (fits(name) || above.empty() || name.size() <= above.size()) return shortened_to(name, fits);
  const std::size_t own = name.size() - above.size();
  if (name.ends_with(above)) {
    const std::string text = std::string(name.substr(0, own)) + "…";
    return fits(text) ? text : shortened_to(name.substr(0, own), fits, 0.0);
  }
  if (name.starts_with(above)) {
    const std::string text = "…" + std::string(name.substr(above.size()));
    return fits(text) ? text : shortened_to(name.substr(above.size()), fits, 1.0);
  }
  return shortened_to(name, fits);
}

}  // namespace sightline::apps
