// One HTML page that holds all it shows: no script, no network. It is well-formed XML, too. All texts may hold any
// bytes: they are escaped.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/core/conventions.h"
#include "sightline/core/error.h"

namespace sightline::apps {

/// Below a figure: what it shows, and the commands that give it again, one a line.
struct Caption {
  std::string text, command;
};

/// An image and what it shows (html_images.h); the same as the bytes of a PNG file.
struct LabelledImage;
struct LabelledPng {
  std::string label;
  std::span<const std::uint8_t> png;
};

/// A word or two on a coloured ground. The words say it all, for who sees no colours.
struct Badge {
  std::string text;
  core::vec3 colour{0.5f};  ///< sRGB, 0 to 1
};
/// "#rrggbb"
std::string hex_of(const core::vec3& colour);

/// The element of an image.
std::string image_element(const LabelledPng& image);

/// The content of a section.
class HtmlBody {
 public:
  void heading(std::string_view text);
  void paragraph(std::string_view text);
  /// A paragraph in large type.
  void lead(std::string_view text);
  /// Lines of shell commands.
  void commands(std::string_view lines);
  void list(const std::vector<std::string>& lines);
  /// The first column holds names, the others numbers. Rows are as long as `head`. Badges, if there are any, stand
  /// before the names, one a row.
  void table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows,
             const Caption& caption, std::span<const Badge> badges = {});
  /// A table with text in all columns.
  void text_table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows,
                  const Caption& caption);
  /// A line with a badge; a click on it shows what is inside.
  void details(const Badge& badge, std::string_view line, const HtmlBody& inside);
  /// Images side by side, so many in a row, 1 to 4.
  void images(std::span<const LabelledPng> images, const Caption& caption, int columns = 2);
  /// Builds without images have neither this nor flip_images().
  core::Expected<void> images(std::span<const LabelledImage> images, const Caption& caption, int columns = 2);
  /// Images in one place, 1 to 4: a click on one shows the next, and so do the arrow keys. `id`: letters and digits,
  /// no other's on the page.
  core::Expected<void> flip_images(std::span<const LabelledImage> images, const Caption& caption,
                                   const std::string& id);
  /// `svg`: an image by SvgCanvas, which is not escaped again.
  void plot(const std::string& svg, const Caption& caption);

  const std::string& text() const { return html_; }

 private:
  void table_of(const char* style, const std::vector<std::string>& head,
                const std::vector<std::vector<std::string>>& rows, const Caption& caption,
                std::span<const Badge> badges);
  void close_figure(const Caption& caption);

  std::string html_;
};

struct PageSection {
  std::string id, title;            ///< id: letters and digits
  std::string headline;             ///< one sentence for the top of the page; may be empty
  std::string body;                 ///< of HtmlBody
  std::optional<Badge> badge = {};  ///< before the title, and before the headline
};

/// Whether sections are closed until a click opens them; their headlines are then no list of their own.
enum class Collapsed { kNo, kYes };
/// `intro`: lines below the title. `opening`: of HtmlBody, between the title and these.
std::string html_page(std::string_view title, const std::vector<std::string>& intro,
                      const std::vector<PageSection>& sections, std::string_view opening = {},
                      Collapsed collapsed = Collapsed::kNo);

}  // namespace sightline::apps
