// One HTML page that holds all it shows: no script, no network. It is well-formed XML, too. All texts may hold any
// bytes: they are escaped.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/core/error.h"
#include "sightline/render/image/image.h"

namespace sightline::apps {

/// Below a figure: what it shows, and the commands that give it again, one a line.
struct Caption {
  std::string text, command;
};

/// An image and what it shows.
struct LabelledImage {
  std::string label;
  image::Image image;
};

/// The content of a section.
class HtmlBody {
 public:
  void heading(std::string_view text);
  void paragraph(std::string_view text);
  /// Lines of shell commands.
  void commands(std::string_view lines);
  void list(const std::vector<std::string>& lines);
  /// The first column holds names, the others numbers. Rows are as long as `head`.
  void table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows,
             const Caption& caption);
  /// The same with text in all columns.
  void text_table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows,
                  const Caption& caption);
  /// Images side by side, so many in a row, 1 to 4.
  core::Expected<void> images(std::span<const LabelledImage> images, const Caption& caption, int columns = 2);
  /// `svg`: an image by SvgCanvas, which is not escaped again.
  void plot(const std::string& svg, const Caption& caption);

  const std::string& text() const { return html_; }

 private:
  void table_of(const char* style, const std::vector<std::string>& head,
                const std::vector<std::vector<std::string>>& rows, const Caption& caption);
  void close_figure(const Caption& caption);

  std::string html_;
};

struct PageSection {
  std::string id, title;  ///< id: letters and digits
  std::string headline;   ///< one sentence for the top of the page; may be empty
  std::string body;       ///< of HtmlBody
};

/// `intro`: lines below the title.
std::string html_page(std::string_view title, const std::vector<std::string>& intro,
                      const std::vector<PageSection>& sections);

}  // namespace sightline::apps
