#include "sightline/apps/common/html_images.h"

#include <utility>
#include <vector>

#include "sightline/apps/common/markup.h"

namespace sightline::apps {
namespace {

core::Expected<std::string> element_of(const LabelledImage& image) {
  return image::encode_png(image.image, image::PngSize::kSmall).map([&](const std::vector<std::uint8_t>& png) {
    return image_element({image.label, png});
  });
}

}  // namespace

core::Expected<void> HtmlBody::images(std::span<const LabelledImage> images, const Caption& caption, int columns) {
  std::vector<std::vector<std::uint8_t>> bytes;
  std::vector<LabelledPng> pngs;
  for (const LabelledImage& image : images) {
    auto png = image::encode_png(image.image, image::PngSize::kSmall);
    if (!png) return tl::unexpected(png.error());
    bytes.push_back(std::move(*png));
    pngs.push_back({image.label, bytes.back()});
  }
  this->images(pngs, caption, columns);
  return {};
}

// Radio buttons need no script: a click on a label chooses one, arrow keys choose the next, and styles show the image
// of the one that is chosen. The label around an image is that of the next button.
core::Expected<void> HtmlBody::flip_images(std::span<const LabelledImage> images, const Caption& caption,
                                           const std::string& id) {
  const auto button = [&](std::size_t i) { return escaped(id) + "-" + std::to_string(i % images.size()); };
  html_ += "<figure>\n<div class=\"flip\">\n";
  for (std::size_t i = 0; i < images.size(); ++i)
    html_ += "<input type=\"radio\" name=\"" + escaped(id) + "\" id=\"" + button(i) + "\"" +
             (i == 0 ? " checked=\"checked\"" : "") + "/><label for=\"" + button(i) + "\">" + escaped(images[i].label) +
             "</label>\n";
  if (images.size() > 1) html_ += "<span class=\"hint\">click the image, or use the arrow keys</span>\n";
  html_ += "<div class=\"frames\">\n";
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto element = element_of(images[i]);
    if (!element) return tl::unexpected(element.error());
    html_ += "<label for=\"" + button(i + 1) + "\">" + *element + "</label>\n";
  }
  html_ += "</div>\n</div>\n";
  close_figure(caption);
  return {};
}

}  // namespace sightline::apps
