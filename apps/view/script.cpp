#include "sightline/apps/view/script.h"

#include <charconv>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/colour_file.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::apps {
namespace {

using core::dvec2;

const std::map<std::string, int> kModifiers{
    {"shift", GLFW_MOD_SHIFT}, {"ctrl", GLFW_MOD_CONTROL}, {"alt", GLFW_MOD_ALT}};
const std::map<std::string, int> kButtons{
    {"left", GLFW_MOUSE_BUTTON_LEFT}, {"right", GLFW_MOUSE_BUTTON_RIGHT}, {"middle", GLFW_MOUSE_BUTTON_MIDDLE}};

std::optional<int> key_of(const std::string& name) {
  static const std::map<std::string, int> names{
      {"escape", GLFW_KEY_ESCAPE}, {"esc", GLFW_KEY_ESCAPE},  {"enter", GLFW_KEY_ENTER},
      {"tab", GLFW_KEY_TAB},       {"space", GLFW_KEY_SPACE}, {"backspace", GLFW_KEY_BACKSPACE},
      {"delete", GLFW_KEY_DELETE}, {"home", GLFW_KEY_HOME},   {"end", GLFW_KEY_END},
      {"left", GLFW_KEY_LEFT},     {"right", GLFW_KEY_RIGHT}, {"up", GLFW_KEY_UP},
      {"down", GLFW_KEY_DOWN}};
  if (const auto at = names.find(name); at != names.end()) return at->second;
  if (name.size() == 1) {
    const char c = name[0];
    if (c >= 'a' && c <= 'z') return GLFW_KEY_A + (c - 'a');
    if (c >= '0' && c <= '9') return GLFW_KEY_0 + (c - '0');
  }
  int number = 0;
  const char* end = name.data() + name.size();
  if (name.size() > 1 && name[0] == 'f' && std::from_chars(name.data() + 1, end, number).ptr == end && number >= 1 &&
      number <= 12)
    return GLFW_KEY_F1 + number - 1;
  return std::nullopt;
}

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

core::Error expected(const std::string& what, const ScriptStep& step) {
  return {step.name + ": expected " + what + ", found \"" + step.argument + "\""};
}

std::optional<double> number_of(std::string_view text) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

/// The first words as numbers; the others stay.
std::optional<std::vector<double>> take_numbers(std::vector<std::string>& words, std::size_t count) {
  std::vector<double> numbers;
  if (words.size() < count) return std::nullopt;
  for (std::size_t i = 0; i < count; ++i) {
    const auto number = number_of(words[i]);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  words.erase(words.begin(), words.begin() + std::ptrdiff_t(count));
  return numbers;
}

struct Press {
  int button = GLFW_MOUSE_BUTTON_LEFT, mods = 0;
};
std::optional<Press> press_of(const std::vector<std::string>& words) {
  Press press;
  for (const std::string& word : words) {
    if (const auto button = kButtons.find(word); button != kButtons.end())
      press.button = button->second;
    else if (const auto mod = kModifiers.find(word); mod != kModifiers.end())
      press.mods |= mod->second;
    else
      return std::nullopt;
  }
  return press;
}

Event cursor(const dvec2& at) {
  return {.type = Event::Type::kCursor, .at = at};
}
Event button(const Press& press, bool down, const dvec2& at) {
  return {.type = Event::Type::kButton, .key = press.button, .mods = press.mods, .down = down, .at = at};
}

/// A click at a point, or a drag along several.
core::Expected<std::vector<Event>> drag(const ScriptStep& step, bool moves) {
  constexpr int kSteps = 4;
  std::vector<std::string> words = words_of(step.argument);
  std::vector<dvec2> points;
  while (const auto at = moves || points.empty() ? take_numbers(words, 2) : std::nullopt)
    points.emplace_back((*at)[0], (*at)[1]);
  const auto press = press_of(words);
  if (points.size() < (moves ? 2u : 1u) || !press)
    return tl::unexpected(
        expected(moves ? "X Y X Y … and buttons or modifiers" : "X Y and buttons or modifiers", step));
  std::vector<Event> events{cursor(points[0]), button(*press, true, points[0])};
  for (std::size_t k = 1; k < points.size(); ++k)
    for (int i = 1; i <= kSteps; ++i)
      events.push_back(cursor(points[k - 1] + (points[k] - points[k - 1]) * (double(i) / kSteps)));
  events.push_back(button(*press, false, points.back()));
  return events;
}

core::Expected<std::vector<Event>> key(const ScriptStep& step) {
  Event event{.type = Event::Type::kKey, .down = true};
  std::string rest = step.argument;
  for (std::size_t plus; (plus = rest.find('+')) != std::string::npos && plus > 0; rest = rest.substr(plus + 1)) {
    const auto mod = kModifiers.find(rest.substr(0, plus));
    if (mod == kModifiers.end()) return tl::unexpected(expected("a key such as f, f1, escape or ctrl+z", step));
    event.mods |= mod->second;
  }
  const auto code = key_of(rest);
  if (!code) return tl::unexpected(expected("a key such as f, f1, escape or ctrl+z", step));
  event.key = *code;
  Event released = event;
  released.down = false;
  released.mods = 0;
  return std::vector<Event>{event, released};
}

/// Characters of UTF-8 text, one each.
std::vector<Event> text(const std::string& typed) {
  std::vector<Event> events;
  for (const char c : typed) {
    if ((c & 0xc0) == 0x80 && !events.empty())
      events.back().text += c;
    else
      events.push_back({.type = Event::Type::kText, .text = std::string(1, c)});
  }
  return events;
}

/// A script ends early where it would write an image under another format's name, not after half of its work.
core::Expected<void> check_image_name(const ScriptStep& step) {
  if (step.name != "screenshot" && step.name != "window-shot") return {};
  const std::size_t space = step.argument.rfind(' ');  // a size may follow
  const auto check = step.name == "screenshot" ? parse_image_name : parse_png_name;
  auto good = check(step.argument);
  if (!good && space != std::string::npos) good = check(step.argument.substr(0, space));
  return good.map([](const std::string&) {});
}

}  // namespace

std::vector<ScriptStep> parse_script(std::string_view text) {
  std::vector<ScriptStep> steps;
  std::istringstream in{std::string(text)};
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    const std::size_t begin = line.find_first_not_of(" \t\r"), end = line.find_last_not_of(" \t\r");
    if (begin == std::string::npos || line[begin] == '#') continue;
    line = line.substr(begin, end - begin + 1);
    const std::size_t space = line.find(' ');
    ScriptStep step{number, line.substr(0, space), {}};
    if (space != std::string::npos) step.argument = line.substr(line.find_first_not_of(' ', space));
    steps.push_back(std::move(step));
  }
  return steps;
}

core::Expected<std::vector<ScriptStep>> read_script(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return core::fail(file.string() + ": cannot be read");
  std::ostringstream text;
  text << in.rdbuf();
  std::vector<ScriptStep> steps = parse_script(text.str());
  for (const ScriptStep& step : steps)
    if (auto good = check_image_name(step); !good)
      return core::fail(file.string() + ":" + std::to_string(step.line) + ": " + good.error().message);
  return steps;
}

core::Expected<std::vector<Event>> events_of(const ScriptStep& step) {
  if (step.name == "click") return drag(step, false);
  if (step.name == "drag") return drag(step, true);
  if (step.name == "press") return key(step);
  if (step.name == "type") return text(step.argument);
  if (step.name != "move" && step.name != "wheel") return std::vector<Event>{};
  std::vector<std::string> words = words_of(step.argument);
  const bool move = step.name == "move";
  const auto numbers = take_numbers(words, move ? 2 : 1);
  if (!numbers || !words.empty()) return tl::unexpected(expected(move ? "X Y" : "a number of notches", step));
  if (move) return std::vector<Event>{cursor({(*numbers)[0], (*numbers)[1]})};
  return std::vector<Event>{{.type = Event::Type::kWheel, .wheel = (*numbers)[0]}};
}

core::Expected<bool> fulfils(const std::string& value, std::string_view demand) {
  const std::size_t space = demand.find(' ');
  const std::string_view sign = demand.substr(0, space),
                         wanted = space == std::string_view::npos ? "" : demand.substr(space + 1);
  int order = value < wanted ? -1 : value > wanted ? 1 : 0;
  if (order != 0 && value.starts_with('"')) {  // what it stands for: names of Windows have backslashes
    const bool quoted = wanted.size() >= 2 && wanted.front() == '"' && wanted.back() == '"';
    const std::string_view bare = quoted ? wanted.substr(1, wanted.size() - 2) : wanted;
    if (const auto text = json::parse(value)) order = text->get<std::string>().compare(bare);
  }
  if (const auto a = number_of(value), b = number_of(wanted); a && b) order = *a < *b ? -1 : *a > *b ? 1 : 0;
  if (sign == "=") return order == 0;
  if (sign == "!=") return order != 0;
  if (sign == "<") return order < 0;
  if (sign == ">") return order > 0;
  if (sign == "<=") return order <= 0;
  if (sign == ">=") return order >= 0;
  return core::fail("expect: expected = != < > <= or >=, found \"" + std::string(sign) + "\"");
}

}  // namespace sightline::apps
