#include "sightline/apps/common/command_line.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <new>
#include <optional>
#include <utility>

#include <CLI/CLI.hpp>

#include "sightline/core/internal/platform/console.h"
#include "sightline/core/internal/platform/files.h"

namespace sightline::apps {
namespace {

static_assert(Option::kUnlimited == CLI::detail::expected_max_vector_size);

template <class T>
CLI::Option* add_to(CLI::App& app, const std::string& name, T& value, const std::string& help) {
  return app.add_option(name, value, help);
}

/// CLI11 would read an empty text as no value.
template <class T>
CLI::Option* add_to(CLI::App& app, const std::string& name, std::optional<T>& value, const std::string& help) {
  return app.add_option_function<T>(
      name, [&value](const T& given) { value = given; }, help);
}

/// CLI11 would read a path as a stream does, up to the first space.
CLI::Option* add_to(CLI::App& app, const std::string& name, std::filesystem::path& value, const std::string& help) {
  return app.add_option_function<std::string>(
      name, [&value](const std::string& text) { value = core::platform::path_of(text); }, help);
}

/// A word where a subcommand is expected, which CLI11 does not name.
std::string unknown_subcommand(const CLI::App& app, int argc, char** argv) {
  const std::vector<const CLI::App*> subcommands = app.get_subcommands({});
  if (subcommands.empty() || argc < 2 || argv[1][0] == '-') return {};
  std::string names;
  for (const CLI::App* const subcommand : subcommands) {
    if (subcommand->get_name() == argv[1]) return {};
    names += (names.empty() ? "" : ", ") + subcommand->get_name();
  }
  return "no subcommand \"" + std::string(argv[1]) + "\": expected one of " + names;
}

/// Group of the options that --help only names.
const char* const kAdvanced = "Advanced options";
constexpr std::size_t kHelpColumn = 28, kHelpWidth = 116;

/// The type of an option's values as people write it: what a list allows, or one word.
std::string value_word(const CLI::Option& option) {
  const std::string type = option.get_type_name(), word = type.substr(0, type.find(':'));
  if (const std::size_t list = type.find(":{"); list != type.npos) {
    std::string choices = type.substr(list + 2, type.find('}') - list - 2);
    std::replace(choices.begin(), choices.end(), ',', '|');
    return choices;
  }
  if (word == "FLOAT") return "X";
  return word == "INT" || word == "UINT" ? "N" : word;
}

/// Help that is read at one glance: the everyday options, and the names of the others, which --help-all describes. What
/// excludes or needs what, error messages tell.
class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter() { column_width(kHelpColumn); }

  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    if (mode == CLI::AppFormatMode::All) return Formatter::make_help(app, std::move(name), mode) + appendix;
    if (mode == CLI::AppFormatMode::Sub) return Formatter::make_help(app, std::move(name), mode);
    return make_description(app) + make_usage(app, std::move(name)) + make_positionals(app) + everyday(app) +
           make_subcommands(app, mode) + '\n' + make_footer(app);
  }

  std::string make_option_name(const CLI::Option* option, bool positional) const override {
    const std::string name = Formatter::make_option_name(option, positional);
    return name.substr(0, name.find('{'));  // a flag's value
  }

  std::string make_option_opts(const CLI::Option* option) const override {
    if (!option->get_option_text().empty()) return " " + option->get_option_text();
    std::string text;
    if (option->get_type_size() != 0) {
      if (const std::string word = value_word(*option); !word.empty()) text += " " + word;
      if (option->get_expected_max() == CLI::detail::expected_max_vector_size) text += " ...";
      if (!option->get_default_str().empty()) text += " (" + option->get_default_str() + ")";
    }
    return text;
  }

  std::string appendix;  ///< of --help-all

 private:
  std::string everyday(const CLI::App* app) const {
    std::string text, names;
    for (const std::string& group : app->get_groups()) {
      const std::vector<const CLI::Option*> options = app->get_options(
          [&](const CLI::Option* option) { return option->get_group() == group && option->nonpositional(); });
      if (group.empty() || options.empty()) continue;
      if (group != kAdvanced) text += make_group(group, false, options);
      for (const CLI::Option* const option : options)
        if (group == kAdvanced) names += " " + option->get_name();
    }
    return text + more(names);
  }

  /// Names after spaces, over lines.
  static std::string more(const std::string& names) {
    if (names.empty()) return {};
    std::string text = "More (--help-all):", line;
    for (std::size_t at = 0; at < names.size();) {
      const std::size_t end = std::min(names.find(' ', at + 1), names.size());
      if (line.size() + end - at > kHelpWidth) text += "\n " + std::exchange(line, {});
      line += names.substr(at, end - at);
      at = end;
    }
    return text + "\n " + line + "\n";
  }
};

}  // namespace

// --- options ---------------------------------------------------------------------------------------------------------

Option Option::required(bool yes) const {
  return Option(option_->required(yes));
}

Option Option::shows_default() const {
  return Option(option_->capture_default_str());
}

Option Option::default_text(const std::string& text) const {
  return Option(option_->default_str(text));
}

Option Option::metavar(const std::string& text) const {
  return Option(option_->type_name(text));
}

Option Option::usage_text(const std::string& text) const {
  return Option(option_->option_text(text));
}

Option Option::described_as(const std::string& text) const {
  return Option(option_->description(text));
}

Option Option::advanced() const {
  return Option(option_->group(kAdvanced));
}

Option Option::hidden() const {
  return Option(option_->group(""));
}

Option Option::takes(int least, int most) const {
  return Option(option_->expected(least, most));
}

Option Option::one_value_each() const {
  return Option(option_->allow_extra_args(false));
}

Option Option::separated_by(char delimiter) const {
  return Option(option_->delimiter(delimiter));
}

template <class T>
Option Option::in_range(T low, T high) const {
  return Option(option_->check(CLI::Range(low, high)));
}

template Option Option::in_range(int, int) const;
template Option Option::in_range(unsigned, unsigned) const;
template Option Option::in_range(std::int64_t, std::int64_t) const;
template Option Option::in_range(std::uint64_t, std::uint64_t) const;
template Option Option::in_range(float, float) const;
template Option Option::in_range(double, double) const;

Option Option::positive() const {
  return Option(option_->check(CLI::PositiveNumber));
}

Option Option::not_negative() const {
  return Option(option_->check(CLI::NonNegativeNumber));
}

Option Option::one_of(const std::vector<std::string>& texts) const {
  return Option(option_->check(CLI::IsMember(texts)));
}

Option Option::existing_file() const {
  return Option(option_->check(CLI::ExistingFile));
}

Option Option::existing_directory() const {
  return Option(option_->check(CLI::ExistingDirectory));
}

Option Option::check(const std::function<core::Expected<void>(const std::string&)>& accept) const {
  const auto complaint = [accept](const std::string& text) {
    const auto accepted = accept(text);
    return accepted ? std::string() : accepted.error().message;
  };
  return Option(option_->check(complaint));
}

Option Option::needs(const Option& other) const {
  return Option(option_->needs(other.option_));
}

Option Option::needs(const std::string& name) const {
  return Option(option_->needs(name));
}

Option Option::excludes(const Option& other) const {
  return Option(option_->excludes(other.option_));
}

Option Option::excludes(std::initializer_list<const char*> names) const {
  for (const std::string name : names) option_->excludes(name);
  return *this;
}

bool Option::given() const {
  return option_->count() > 0;
}

// --- command lines ---------------------------------------------------------------------------------------------------

CommandLine::CommandLine(const std::string& description, const std::string& tool, const std::string& examples)
    : CommandLine(std::make_shared<CLI::App>(description, tool)) {
  app_->formatter(std::make_shared<HelpFormatter>());
  app_->set_help_all_flag("--help-all", "Describe all options");
  app_->allow_windows_style_options(false);  // a name that begins with a slash is that of a file
  describe(examples);
}

CommandLine::CommandLine(std::shared_ptr<CLI::App> app)
    : app_(std::move(app)), rules_(std::make_shared<Rules>()), groups_(std::make_shared<Groups>()) {}

Option CommandLine::added(CLI::Option* option) {
  groups_->emplace(option, group_);
  return Option(option);
}

template <class T>
Option CommandLine::add(const std::string& name, T& value, const std::string& help) {
  return added(add_to(*app_, name, value, help));
}

template Option CommandLine::add(const std::string&, std::string&, const std::string&);
template Option CommandLine::add(const std::string&, std::filesystem::path&, const std::string&);
template Option CommandLine::add(const std::string&, int&, const std::string&);
template Option CommandLine::add(const std::string&, unsigned&, const std::string&);
template Option CommandLine::add(const std::string&, std::int64_t&, const std::string&);
template Option CommandLine::add(const std::string&, std::uint64_t&, const std::string&);
template Option CommandLine::add(const std::string&, float&, const std::string&);
template Option CommandLine::add(const std::string&, double&, const std::string&);
template Option CommandLine::add(const std::string&, std::optional<double>&, const std::string&);
template Option CommandLine::add(const std::string&, std::optional<std::uint64_t>&, const std::string&);
template Option CommandLine::add(const std::string&, std::vector<std::string>&, const std::string&);
template Option CommandLine::add(const std::string&, std::vector<int>&, const std::string&);
template Option CommandLine::add(const std::string&, std::vector<std::uint64_t>&, const std::string&);
template Option CommandLine::add(const std::string&, std::vector<double>&, const std::string&);

Option CommandLine::add_text(const std::string& name, const std::function<void(const std::string&)>& set,
                             const std::function<std::string()>& get, const std::string& help) {
  CLI::Option* option = app_->add_option_function<std::string>(name, set, help);
  option->default_function(get);
  return added(option);
}

Option CommandLine::add_flag(const std::string& name, bool& value, const std::string& help) {
  return added(app_->add_flag(name, value, help));
}

Option CommandLine::option(const std::string& name) const {
  return Option(app_->get_option(name));
}

void CommandLine::describe(const std::string& lines) {
  app_->set_version_flag("--version", std::string("sightline ") + SIGHTLINE_VERSION);
  examples(lines);
}

void CommandLine::examples(const std::string& lines) {
  app_->footer("Examples:\n" + lines);
}

void CommandLine::appendix(const std::string& text) {
  std::static_pointer_cast<HelpFormatter>(app_->get_formatter())->appendix = text;
}

CommandLine CommandLine::group(OptionGroup group) const {
  CommandLine line = *this;
  line.group_ = group;
  return line;
}

void CommandLine::mode(const Option& option, std::initializer_list<OptionGroup> supported) {
  CLI::Option* const mode = option.option_;
  // Rules are part of the application, so they may not keep it alive.
  const auto refused = [mode, app = app_.get(), groups = groups_, supported = std::vector(supported)] {
    std::vector<const CLI::Option*> found;
    for (const CLI::Option* const other : app->get_options()) {
      const auto known = groups->find(other);  // --help and --version are not
      if (other != mode && known != groups->end() &&
          std::find(supported.begin(), supported.end(), known->second) == supported.end())
        found.push_back(other);
    }
    return found;
  };
  check([mode, refused]() -> core::Expected<void> {
    if (mode->count() == 0) return {};
    for (const CLI::Option* const other : refused())
      if (other->count() > 0) return core::fail(other->get_name() + " is not available with " + mode->get_name());
    return {};
  });
}

CommandLine CommandLine::exactly_one_of(const std::string& title) {
  CLI::App* group = app_->add_option_group(title);
  group->require_option(1);
  return CommandLine({app_, group});
}

CommandLine CommandLine::subcommand(const std::string& name, const std::string& description) {
  return CommandLine({app_, app_->add_subcommand(name, description)});
}

void CommandLine::require_subcommand() {
  app_->require_subcommand(1);
}

bool CommandLine::chosen() const {
  return app_->parsed();
}

void CommandLine::check(const std::function<core::Expected<void>()>& rule) {
  rules_->push_back(rule);
  app_->final_callback([rules = rules_] {
    for (const auto& each : *rules)
      if (const auto kept = each(); !kept) throw CLI::ValidationError(kept.error().message);
  });
}

int CommandLine::run(int argc, char** argv, const std::function<core::Expected<int>()>& body) {
  const std::string tool = app_->get_name();
  std::vector<std::string> arguments = core::platform::begin_program(argc, argv);
  std::vector<char*> words;
  for (std::string& argument : arguments) words.push_back(argument.data());
  argc = int(words.size()), argv = words.data();
  try {
    app_->parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app_->exit(error);  // --help, --version
    const std::string unknown = unknown_subcommand(*app_, argc, argv);
    std::fprintf(stderr, "%s: %s (see --help)\n", tool.c_str(), unknown.empty() ? error.what() : unknown.c_str());
    return kExitUsage;
  }
  try {
    const core::Expected<int> result = body();
    if (result) return *result;
    if (result.error().message.empty()) return kExitOk;
    std::fprintf(stderr, "%s: %s\n", tool.c_str(), result.error().message.c_str());
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "%s: not enough memory\n", tool.c_str());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", tool.c_str(), error.what());
  }
  return kExitFailure;
}

void add_json_option(CommandLine& line, std::string& file) {
  line.group(OptionGroup::kGeneral)
      .add("--json", file, "Write the figures as JSON to FILE, or - for stdout")
      .usage_text("FILE");
}

}  // namespace sightline::apps
