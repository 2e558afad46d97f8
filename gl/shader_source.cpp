#include "sightline/gl/internal/shader_source.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include <fmt/format.h>

namespace sightline::gl {
namespace {

constexpr std::string_view kBlank = " \t\r";

// Mesa omits the source number of a #line directive in most of its messages, but never the line. So the line number
// also holds the file: line 12 of file 3 is 300012.
constexpr std::size_t kLinesPerFile = 100000;

/// Cuts the first line off `rest`, without its newline.
std::string_view take_line(std::string_view& rest) {
  const std::size_t end = rest.find('\n');
  const std::string_view line = rest.substr(0, end);
  rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  return line;
}

/// The text after "#word" if the line is that directive.
std::optional<std::string_view> directive(std::string_view line, std::string_view word) {
  const auto skip_blank = [&] {
    const std::size_t start = line.find_first_not_of(kBlank);
    line = start == std::string_view::npos ? std::string_view() : line.substr(start);
  };
  skip_blank();
  if (line.empty() || line.front() != '#') return std::nullopt;
  line.remove_prefix(1);
  skip_blank();
  if (line.substr(0, word.size()) != word) return std::nullopt;
  line.remove_prefix(word.size());
  skip_blank();
  return line;
}

/// The name between the quotes of an #include; empty when malformed.
std::string_view quoted_name(std::string_view text) {
  if (text.empty() || text.front() != '"') return {};
  const std::size_t end = text.find('"', 1);
  if (end == std::string_view::npos) return {};
  if (const std::size_t more = text.find_first_not_of(kBlank, end + 1);
      more != std::string_view::npos && text.substr(more, 2) != "//") {
    return {};
  }
  return text.substr(1, end - 1);
}

std::optional<ShaderFile> find_file(const ShaderContext& context, std::string_view name) {
  for (const ShaderTable& table : context.tables) {
    for (const ShaderFile& file : table) {
      if (file.first == name) return file;
    }
  }
  return std::nullopt;
}

/// Expands includes with an explicit stack.
class Assembler {
 public:
  explicit Assembler(const ShaderContext& context) : context_(context) {
    source_.files.emplace_back("prolog");
    source_.text = "#version 450 core\n";
    for (const std::string& extension : context.extensions) {
      source_.text += "#extension " + extension + " : require\n";
    }
    for (const std::string& define : context.defines) source_.text += "#define " + define + "\n";
  }

  core::Expected<void> add(const std::string& name) {
    if (auto opened = open(name, "stage"); !opened) return opened;
    while (!stack_.empty()) {
      if (stack_.back().rest.empty()) {
        close();
      } else if (auto done = expand_line(); !done) {
        return done;
      }
    }
    return {};
  }

  StageSource take() { return std::move(source_); }

 private:
  struct Open {
    std::string_view name;
    std::string_view rest;
    std::size_t index = 0;  // into source_.files
    std::size_t line = 0;   // number of the line last taken
  };

  core::Expected<void> open(std::string_view name, const std::string& from) {
    const auto file = find_file(context_, name);
    if (!file) return core::fail(fmt::format("{}: no shader file is named '{}'", from, name));
    source_.files.emplace_back(file->first);
    stack_.push_back({file->first, file->second, source_.files.size() - 1, 0});
    add_line_directive();
    return {};
  }

  void close() {
    stack_.pop_back();
    if (!stack_.empty()) add_line_directive();
  }

  /// Tells the compiler where the next line comes from. Since GLSL 3.30 the number is that of the line after the
  /// directive.
  void add_line_directive() {
    const Open& top = stack_.back();
    source_.text += fmt::format("#line {} {}\n", top.index * kLinesPerFile + top.line + 1, top.index);
  }

  core::Expected<void> expand_line() {
    Open& top = stack_.back();
    const std::string_view line = take_line(top.rest);
    ++top.line;
    if (directive(line, "version")) {
      return core::fail(fmt::format("{}:{}: #version is the builder's to write", top.name, top.line));
    }
    const auto include = directive(line, "include");
    if (!include) {
      source_.text.append(line);
      source_.text += '\n';
      return {};
    }
    return expand_include(quoted_name(*include), fmt::format("{}:{}", top.name, top.line));
  }

  core::Expected<void> expand_include(std::string_view name, const std::string& where) {
    if (name.empty()) return core::fail(where + ": expected #include \"name\"");
    for (const Open& open_file : stack_) {
      if (open_file.name == name) return core::fail(fmt::format("{}: include cycle: {}{}", where, chain(), name));
    }
    if (std::find(source_.files.begin() + 1, source_.files.end(), name) != source_.files.end()) {
      source_.text += '\n';
      return {};
    }
    return open(name, where);
  }

  std::string chain() const {
    std::string text;
    for (const Open& open_file : stack_) text += std::string(open_file.name) + " -> ";
    return text;
  }

  const ShaderContext& context_;
  StageSource source_;
  std::vector<Open> stack_;
};

/// Removes a number from the front.
std::optional<std::size_t> take_number(std::string_view& text) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end == text.data()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

/// Replaces "1:100012(3): error" or "1(100012) : error" by the file's name and line; returns any other line unchanged.
std::string name_file_in_line(std::string_view line, std::span<const std::string> files) {
  std::string_view rest = line;
  std::string_view prefix;
  for (const std::string_view severity : {"ERROR: ", "WARNING: "}) {
    if (rest.substr(0, severity.size()) != severity) continue;
    prefix = rest.substr(0, severity.size());
    rest.remove_prefix(severity.size());
  }
  if (!take_number(rest) || rest.empty()) return std::string(line);
  const bool parenthesis = rest.front() == '(';
  if (!parenthesis && rest.front() != ':') return std::string(line);
  rest.remove_prefix(1);
  const auto number = take_number(rest);
  if (!number || *number / kLinesPerFile >= files.size()) return std::string(line);
  if (parenthesis && !rest.empty() && rest.front() == ')') rest.remove_prefix(1);
  return fmt::format("{}{}:{}{}", prefix, files[*number / kLinesPerFile], *number % kLinesPerFile, rest);
}

}  // namespace

core::Expected<StageSource> assemble_stage(const ShaderContext& context, std::span<const std::string> files) {
  Assembler assembler(context);
  for (const std::string& file : files) {
    if (auto added = assembler.add(file); !added) return tl::unexpected(added.error());
  }
  return assembler.take();
}

ShaderContext with_workarounds(ShaderContext context, Workarounds workarounds) {
  if (workarounds[Workaround::kPlainDepth]) context.defines.emplace_back("PLAIN_DEPTH");
  if (workarounds[Workaround::kAddBaseVertex]) {
    context.defines.emplace_back("ADD_BASE_VERTEX");
    context.extensions.emplace_back("GL_ARB_shader_draw_parameters");
  }
  return context;
}

std::string name_files_in_log(std::string_view log, std::span<const std::string> files) {
  std::string named;
  while (!log.empty()) {
    const std::string_view line = take_line(log);
    if (line.find_first_not_of(kBlank) == std::string_view::npos) continue;
    if (!named.empty()) named += '\n';
    named += name_file_in_line(line, files);
  }
  return named;
}

}  // namespace sightline::gl
