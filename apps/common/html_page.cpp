#include "sightline/apps/common/html_page.h"

#include "sightline/apps/common/markup.h"

namespace sightline::apps {
namespace {

constexpr std::string_view kStyle = R"(
body { counter-reset: figure; max-width: 60rem; margin: 0 auto; padding: 1rem; color: #000; background: #fff;
       font: 15px/1.45 "Liberation Sans", Arial, Helvetica, sans-serif; }
h1 { font-size: 1.7rem; margin: 0.5rem 0; overflow-wrap: anywhere; }
h2 { font-size: 1.3rem; margin: 2.2rem 0 0.6rem; padding-bottom: 0.2rem; border-bottom: 2px solid #000; }
h3 { font-size: 1.05rem; margin: 1.4rem 0 0.4rem; }
p, li { overflow-wrap: anywhere; }
p { margin: 0.5rem 0; }
figure { margin: 1rem 0 1.4rem; counter-increment: figure; }
figcaption { margin-top: 0.4rem; font-size: 0.85rem; color: #222; }
figcaption::before { content: "Figure " counter(figure) ". "; font-weight: bold; }
code { display: block; margin-top: 0.2rem; white-space: pre-wrap; overflow-wrap: anywhere; font-size: 0.8rem;
       font-family: "Liberation Mono", Consolas, monospace; }
img, svg { display: block; max-width: 100%; height: auto; }
img { width: 100%; border: 1px solid #999; box-sizing: border-box; }
.images { display: grid; grid-template-columns: repeat(var(--columns), minmax(0, 1fr)); gap: 0.8rem; }
.images > div { font-size: 0.85rem; }
table { border-collapse: collapse; width: 100%; font-size: 0.9rem; }
th, td { padding: 0.15rem 0.5rem; border-bottom: 1px solid #ccc; text-align: left; vertical-align: top; }
.texts td { overflow-wrap: anywhere; }
thead th { border-bottom: 1px solid #000; vertical-align: bottom; }
tbody th { font-weight: normal; }
.numbers td, .numbers thead th + th { text-align: right; font-variant-numeric: tabular-nums; }
@page { margin: 15mm; }
@media print {
  body { max-width: none; padding: 0; font-size: 10pt; }
  a { color: #000; text-decoration: none; }
  figure { break-inside: avoid; }
  h2, h3 { break-after: avoid; }
}
)";

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t k) { return i + k < bytes.size() ? std::uint32_t(bytes[i + k]) : 0u; };
    const std::uint32_t word = byte(0) << 16 | byte(1) << 8 | byte(2);
    for (std::size_t k = 0; k < 4; ++k) out += i + k <= bytes.size() ? kDigits[word >> (18 - 6 * k) & 63u] : '=';
  }
  return out;
}

}  // namespace

void HtmlBody::heading(std::string_view text) {
  html_ += "<h3>" + escaped(text) + "</h3>\n";
}

void HtmlBody::paragraph(std::string_view text) {
  html_ += "<p>" + escaped(text) + "</p>\n";
}

void HtmlBody::commands(std::string_view lines) {
  html_ += "<p><code>" + escaped(lines) + "</code></p>\n";
}

void HtmlBody::list(const std::vector<std::string>& lines) {
  if (lines.empty()) return;
  html_ += "<ul>\n";
  for (const std::string& line : lines) html_ += "<li>" + escaped(line) + "</li>\n";
  html_ += "</ul>\n";
}

void HtmlBody::table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows,
                     const Caption& caption) {
  table_of("numbers", head, rows, caption);
}

void HtmlBody::text_table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows,
                          const Caption& caption) {
  table_of("texts", head, rows, caption);
}

void HtmlBody::table_of(const char* style, const std::vector<std::string>& head,
                        const std::vector<std::vector<std::string>>& rows, const Caption& caption) {
  html_ += std::string("<figure>\n<table class=\"") + style + "\">\n<thead><tr>";
  for (const std::string& cell : head) html_ += "<th scope=\"col\">" + escaped(cell) + "</th>";
  html_ += "</tr></thead>\n<tbody>\n";
  for (const std::vector<std::string>& row : rows) {
    html_ += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i)
      html_ += i == 0 ? "<th scope=\"row\">" + escaped(row[i]) + "</th>" : "<td>" + escaped(row[i]) + "</td>";
    html_ += "</tr>\n";
  }
  html_ += "</tbody>\n</table>\n";
  close_figure(caption);
}

core::Expected<void> HtmlBody::images(std::span<const LabelledImage> images, const Caption& caption, int columns) {
  html_ += "<figure>\n<div class=\"images\" style=\"--columns: " + std::to_string(columns) + "\">\n";
  for (const auto& [label, image] : images) {
    const auto png = image::encode_png(image, image::PngSize::kSmall);
    if (!png) return tl::unexpected(png.error());
    html_ += "<div>" + escaped(label) + "<img alt=\"" + escaped(label) + "\" src=\"data:image/png;base64," +
             base64(*png) + "\"/></div>\n";
  }
  html_ += "</div>\n";
  close_figure(caption);
  return {};
}

void HtmlBody::plot(const std::string& svg, const Caption& caption) {
  html_ += "<figure>\n" + svg;
  close_figure(caption);
}

void HtmlBody::close_figure(const Caption& caption) {
  html_ += "<figcaption>" + escaped(caption.text);
  if (!caption.command.empty()) html_ += "<code>" + escaped(caption.command) + "</code>";
  html_ += "</figcaption>\n</figure>\n";
}

std::string html_page(std::string_view title, const std::vector<std::string>& intro,
                      const std::vector<PageSection>& sections) {
  // The policy keeps a browser from loading anything, whatever a name in a model may hold.
  std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; "
      "style-src 'unsafe-inline'\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>" +
      escaped(title) + "</title>\n<style>" + std::string(kStyle) + "</style>\n</head>\n<body>\n<h1>" + escaped(title) +
      "</h1>\n";
  for (const std::string& line : intro) page += "<p>" + escaped(line) + "</p>\n";
  page += "<ul>\n";
  for (const PageSection& section : sections) {
    page += "<li><a href=\"#" + escaped(section.id) + "\">" + escaped(section.title) + "</a>";
    if (!section.headline.empty()) page += ": " + escaped(section.headline);
    page += "</li>\n";
  }
  page += "</ul>\n";
  for (const PageSection& section : sections)
    page += "<section id=\"" + escaped(section.id) + "\">\n<h2>" + escaped(section.title) + "</h2>\n" + section.body +
            "</section>\n";
  return page + "</body>\n</html>\n";
}

}  // namespace sightline::apps
