// Command lines of all tools: their options, --help and --version, usage errors and exit codes. The façade hides CLI11,
// which costs seconds of compile time: command_line.cpp alone includes it.
#pragma once

#include <functional>
#include <initializer_list>
#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "sightline/core/error.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace sightline::apps {

inline constexpr int kExitOk = 0;
inline constexpr int kExitFailure = 1;  ///< bad input or a failed comparison
inline constexpr int kExitUsage = 2;

/// Options by what they need of the tool's mode. A mode, such as --mpi, names once the groups that it supports
/// (CommandLine::mode).
enum class OptionGroup {
  kPlain,    ///< the mode without a mode's option alone; options are of this group unless they are added to another
  kGeneral,  ///< nothing: the model, the view, files that are written
  kImport,   ///< model files that are read and placed here
  kEngine,   ///< engine::Engine, with the whole scene
  kPaged,    ///< engine::PagedEngine, and the mode without a mode's option
};

/// Handle of one option, valid while its command line exists. Copies name the same option. Functions that change the
/// option return its handle, so that calls can be chained.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option required(bool yes = true) const;

  // The help text, which shows names, value type and default of an option before its description.
  Option shows_default() const;                        ///< the value that the option's variable has now
  Option default_text(const std::string& text) const;  ///< shows this text as the default
  Option metavar(const std::string& text) const;       ///< replaces the name of the value type, such as TEXT
  Option usage_text(const std::string& text) const;    ///< replaces everything between names and description
  Option described_as(const std::string& text) const;  ///< replaces the description
  Option advanced() const;                             ///< described by --help-all alone; --help only names it
  Option hidden() const;                               ///< leaves the option out of the help text

  // How many values the option takes.
  static constexpr int kUnlimited = 1 << 29;
  Option takes(int count) const { return takes(count, count); }
  Option takes(int least, int most) const;
  Option one_value_each() const;              ///< one value each time that the option is given, for lists
  Option separated_by(char delimiter) const;  ///< splits a value at the delimiter into several

  // Checks of each value. Values of a list are checked one by one, and every check has to pass.

  /// From `low` to `high`, for int, unsigned, std::int64_t, std::uint64_t, float and double. The type decides how help
  /// and messages write the bounds. NaN passes; use parse_finite() against it.
  template <class T>
  Option in_range(T low, T high) const;
  Option positive() const;
  Option not_negative() const;
  Option one_of(const std::vector<std::string>& texts) const;  ///< help lists them in this order
  Option existing_file() const;
  Option existing_directory() const;
  Option check(const std::function<core::Expected<void>(const std::string&)>& accept) const;
  template <class T>
  Option accepted_by(core::Expected<T> (*parse)(const std::string&)) const {
    return check([parse](const std::string& text) { return parse(text).map([](const T&) {}); });
  }

  // Relations to other options of the same command line. An unknown name is a bug of the tool and throws.
  Option needs(const Option& other) const;
  Option needs(const std::string& name) const;
  Option excludes(const Option& other) const;  ///< in both directions
  Option excludes(std::initializer_list<const char*> names) const;

  bool given() const;  ///< after parsing: whether the command line had it

 private:
  friend class CommandLine;

  CLI::Option* option_;
};

/// Handle of a tool's command line, of a subcommand, or of a group of options. Copies name the same one, and the
/// command line exists as long as a handle of it or of its parts. Variables of options have to outlive run().
class CommandLine {
 public:
  /// Has --help, --help-all and --version. `examples`: lines that begin with two spaces, below the help text.
  CommandLine(const std::string& description, const std::string& tool, const std::string& examples);

  /// Option that is stored in `value`: "--name", "-n,--name", or "NAME" for a positional argument. T is std::string,
  /// std::filesystem::path, a number type of Option::in_range(), std::optional of double or std::uint64_t, or
  /// std::vector of std::string, int, std::uint64_t or double, which takes any number of values.
  template <class T>
  Option add(const std::string& name, T& value, const std::string& help);

  /// Sets `value` when "--name" is given, or clears it for a name of the form "!--no-name".
  Option add_flag(const std::string& name, bool& value, const std::string& help = {});

  /// Option whose text names one of `choices`, which help lists in the order of the names.
  template <class T>
  Option add_choice(const std::string& name, T& value, const std::type_identity_t<std::map<std::string, T>>& choices,
                    const std::string& help) {
    std::vector<std::string> names;
    for (const auto& [text, choice] : choices) names.push_back(text);
    const auto set = [&value, choices](const std::string& text) { value = choices.at(text); };
    const auto get = [&value, choices] {
      for (const auto& [text, choice] : choices)
        if (choice == value) return text;
      return std::string();
    };
    return add_text(name, set, get, help).one_of(names);
  }

  /// Option whose text `parse` turns into the value, or refuses.
  template <class T, class Value>
  Option add_parsed(const std::string& name, T& value, core::Expected<Value> (*parse)(const std::string&),
                    const std::string& help) {
    const auto set = [&value, parse](const std::string& text) { value = parse(text).value(); };
    return add_text(name, set, {}, help).accepted_by(parse);
  }

  /// Option that was added. An unknown name is a bug of the tool and throws.
  Option option(const std::string& name) const;

  /// Adds --version, and the examples below the help text. The constructor does it for a tool.
  void describe(const std::string& examples);
  /// Sets the examples alone, for a subcommand.
  void examples(const std::string& lines);
  /// What --help-all says after the options.
  void appendix(const std::string& text);

  /// Handle of the same command line that adds options of a group.
  CommandLine group(OptionGroup group) const;

  /// Makes an option a mode of the tool. Options of other groups than `supported` are bad usage beside it, also those
  /// that are added later.
  void mode(const Option& option, std::initializer_list<OptionGroup> supported);

  /// Group of options, under a title in the help text, of which exactly one has to be given.
  CommandLine exactly_one_of(const std::string& title);

  CommandLine subcommand(const std::string& name, const std::string& description);
  void require_subcommand();
  bool chosen() const;  ///< after parsing: whether this is the subcommand that was given

  /// Runs `rule` when all options are stored, in the order of the calls. A rule refuses a combination of options, or
  /// adjusts their variables. Its error is bad usage.
  void check(const std::function<core::Expected<void>()>& rule);

  /// Parses the command line and runs a tool. Its error becomes one line on stderr and exit 1. An error without a
  /// message belongs to another process, which prints it: exit 0, or mpirun would end that process before it can. Bad
  /// usage gives exit 2. An exception of a library (no memory) gives exit 1.
  int run(int argc, char** argv, const std::function<core::Expected<int>()>& body);

 private:
  using Rules = std::vector<std::function<core::Expected<void>()>>;
  using Groups = std::map<const CLI::Option*, OptionGroup>;

  explicit CommandLine(std::shared_ptr<CLI::App> app);
  Option added(CLI::Option* option);
  Option add_text(const std::string& name, const std::function<void(const std::string&)>& set,
                  const std::function<std::string()>& get, const std::string& help);

  std::shared_ptr<CLI::App> app_;
  std::shared_ptr<Rules> rules_;
  std::shared_ptr<Groups> groups_;
  OptionGroup group_ = OptionGroup::kPlain;  // of options that this handle adds
};

/// --json FILE, into `file`.
void add_json_option(CommandLine& line, std::string& file);

}  // namespace sightline::apps
