#include "sightline/apps/common/html_page.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sightline/apps/common/markup.h"
#include "sightline/core/internal/srgb.h"
#include "sightline/importers/internal/base64.h"

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
.lead { font-size: 1.3rem; line-height: 1.35; margin: 0.8rem 0; }
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
.texts td:nth-child(2):not(:last-child) { white-space: nowrap; }
thead th { border-bottom: 1px solid #000; vertical-align: bottom; }
tbody th { font-weight: normal; }
.numbers td, .numbers thead th + th { text-align: right; font-variant-numeric: tabular-nums; }
.badge { padding: 0 0.45em; border-radius: 0.25em; font-weight: bold; white-space: nowrap; }
details { margin: 0.3rem 0; overflow-wrap: anywhere; }
details > figure { margin: 0.4rem 0 0.8rem 1.5rem; }
details.section { border-top: 1px solid #999; padding: 0.5rem 0; }
summary { cursor: pointer; }
.flip > input { margin: 0 0.2em 0 0; }
.flip > label { margin-right: 1em; font-size: 0.85rem; cursor: pointer; }
.flip > input:checked + label { font-weight: bold; }
.flip > .hint { font-size: 0.85rem; color: #555; }
.flip > .frames { margin-top: 0.3rem; }
.flip > .frames > label { display: none; cursor: pointer; }
.flip > input:nth-of-type(1):checked ~ .frames > label:nth-of-type(1),
.flip > input:nth-of-type(2):checked ~ .frames > label:nth-of-type(2),
.flip > input:nth-of-type(3):checked ~ .frames > label:nth-of-type(3),
.flip > input:nth-of-type(4):checked ~ .frames > label:nth-of-type(4) { display: block; }
.flip > input:focus-visible ~ .frames { outline: 3px solid #0b5cad; }
@page { margin: 15mm; }
@media print {
  .flip > .hint { display: none; }
  .flip > .frames > label { display: block; }
  .badge { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  body { max-width: none; padding: 0; font-size: 10pt; }
  a { color: #000; text-decoration: none; }
  figure, tr { break-inside: avoid; }
  figure:has(.texts) { break-inside: auto; }
  figcaption { break-before: avoid; break-inside: avoid; }
  h2, h3 { break-after: avoid; }
}
)";

/// The linear luminance of an sRGB colour, 0 to 1 (WCAG 2).
double luminance(const core::vec3& colour) {
  const auto linear = [](float channel) { return core::linear_from_srgb(double(channel)); };
  return 0.2126 * linear(colour.r) + 0.7152 * linear(colour.g) + 0.0722 * linear(colour.b);
}

std::string html_of(const Badge& badge) {
  // Whichever of black and white has the greater contrast: they are equal at this luminance.
  const char* ink = luminance(badge.colour) > 0.179 ? "#000" : "#fff";
  return "<span class=\"badge\" style=\"background: " + hex_of(badge.colour) + "; color: " + ink + "\">" +
         escaped(badge.text) + "</span>";
}

std::string badge_of(const PageSection& section) {
  return section.badge ? html_of(*section.badge) + " " : "";
}

/// A list of links, and then the sections.
std::string listed_sections(const std::vector<PageSection>& sections) {
  std::string html = "<ul>\n";
  for (const PageSection& section : sections) {
    html += "<li>" + badge_of(section) + "<a href=\"#" + escaped(section.id) + "\">" + escaped(section.title) + "</a>";
    if (!section.headline.empty()) html += ": " + escaped(section.headline);
    html += "</li>\n";
  }
  html += "</ul>\n";
  for (const PageSection& section : sections)
    html += "<section id=\"" + escaped(section.id) + "\">\n<h2>" + badge_of(section) + escaped(section.title) +
            "</h2>\n" + section.body + "</section>\n";
  return html;
}

std::string collapsed_sections(const std::vector<PageSection>& sections) {
  std::string html;
  for (const PageSection& section : sections)
    html += "<details class=\"section\" id=\"" + escaped(section.id) + "\"><summary>" + badge_of(section) + "<b>" +
            escaped(section.title) + "</b>" + (section.headline.empty() ? "" : ": " + escaped(section.headline)) +
            "</summary>\n<section>\n" + section.body + "</section>\n</details>\n";
  return html;
}

}  // namespace

std::string hex_of(const core::vec3& colour) {
  const auto byte = [](float channel) { return unsigned(std::lround(255.0f * std::clamp(channel, 0.0f, 1.0f))); };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(colour.r), byte(colour.g), byte(colour.b));
}

std::string image_element(const LabelledPng& image) {
  return "<img alt=\"" + escaped(image.label) + "\" src=\"data:image/png;base64," + importers::base64(image.png) +
         "\"/>";
}

void HtmlBody::images(std::span<const LabelledPng> images, const Caption& caption, int columns) {
  html_ += "<figure>\n<div class=\"images\" style=\"--columns: " + std::to_string(columns) + "\">\n";
  for (const LabelledPng& image : images) html_ += "<div>" + escaped(image.label) + image_element(image) + "</div>\n";
  html_ += "</div>\n";
  close_figure(caption);
}

void HtmlBody::heading(std::string_view text) {
  html_ += "<h3>" + escaped(text) + "</h3>\n";
}

void HtmlBody::paragraph(std::string_view text) {
  html_ += "<p>" + escaped(text) + "</p>\n";
}

void HtmlBody::lead(std::string_view text) {
  html_ += "<p class=\"lead\">" + escaped(text) + "</p>\n";
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
                     const Caption& caption, std::span<const Badge> badges) {
  table_of("numbers", head, rows, caption, badges);
}

void HtmlBody::text_table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows,
                          const Caption& caption) {
  table_of("texts", head, rows, caption, {});
}

void HtmlBody::table_of(const char* style, const std::vector<std::string>& head,
                        const std::vector<std::vector<std::string>>& rows, const Caption& caption,
                        std::span<const Badge> badges) {
  html_ += std::string("<figure>\n<table class=\"") + style + "\">\n<thead><tr>";
  for (const std::string& cell : head) html_ += "<th scope=\"col\">" + escaped(cell) + "</th>";
  html_ += "</tr></thead>\n<tbody>\n";
  for (std::size_t r = 0; r < rows.size(); ++r) {
    html_ +=
        "<tr><th scope=\"row\">" + (r < badges.size() ? html_of(badges[r]) + " " : "") + escaped(rows[r][0]) + "</th>";
    for (std::size_t i = 1; i < rows[r].size(); ++i) html_ += "<td>" + escaped(rows[r][i]) + "</td>";
    html_ += "</tr>\n";
  }
  html_ += "</tbody>\n</table>\n";
  close_figure(caption);
}

void HtmlBody::details(const Badge& badge, std::string_view line, const HtmlBody& inside) {
  html_ +=
      "<details><summary>" + html_of(badge) + " " + escaped(line) + "</summary>\n" + inside.text() + "</details>\n";
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
                      const std::vector<PageSection>& sections, std::string_view opening, Collapsed collapsed) {
  // The policy keeps a browser from loading anything, whatever a name in a model may hold.
  std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; "
      "style-src 'unsafe-inline'\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>" +
      escaped(title) + "</title>\n<style>" + std::string(kStyle) + "</style>\n</head>\n<body>\n<h1>" + escaped(title) +
      "</h1>\n" + std::string(opening);
  for (const std::string& line : intro) page += "<p>" + escaped(line) + "</p>\n";
  page += collapsed == Collapsed::kYes ? collapsed_sections(sections) : listed_sections(sections);
  return page + "</body>\n</html>\n";
}

}  // namespace sightline::apps
