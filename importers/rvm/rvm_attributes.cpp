#include "sightline/importers/rvm/internal/rvm_attributes.h"

#include <algorithm>
#include <string_view>
#include <tuple>
#include <vector>

#include <fmt/format.h>

#include "sightline/core/internal/platform/files.h"
#include "sightline/importers/internal/import_job.h"
#include "sightline/importers/internal/text_encoding.h"
#include "sightline/importers/internal/text_scanner.h"

namespace sightline::importers {
namespace {

std::string_view unquoted(std::string_view text) {
  const bool quoted = text.size() >= 2 && (text.front() == '\'' || text.front() == '"') && text.back() == text.front();
  return quoted ? text.substr(1, text.size() - 2) : text;
}

struct Attribute {
  std::string_view key, value;
};

/// An element of the file. Elements are in the file's order, parents first. The views point into the file.
struct AttributeElement {
  std::string_view name;
  std::uint32_t parent = core::kNone;
  std::vector<Attribute> attributes;
};

/// The words that give a file its structure.
struct Words {
  std::string_view start = "NEW", end = "END", name_end = ":=", separator = "&end&";
};

class AttributeText {
 public:
  AttributeText(std::string_view text, ImportJob& job)
      : text_(text), job_(job), line_end_(text.find('\n') == std::string_view::npos ? '\r' : '\n') {}

  core::Expected<std::vector<AttributeElement>> parse() {
    if (auto begun = read_header(); !begun) return tl::unexpected(begun.error());
    while (at_ < text_.size()) {
      if (auto read = read_line(trimmed(next_line())); !read) return tl::unexpected(read.error());
      if (auto asked = job_.progress(0.8 * double(at_) / double(text_.size())); !asked)
        return tl::unexpected(asked.error());
    }
    if (!open_.empty() || skipped_ > 0)
      if (auto told = damage(fmt::format("expected {} more '{}'", open_.size() + skipped_, words_.end)); !told)
        return tl::unexpected(told.error());
    return std::move(elements_);
  }

 private:
  std::string_view next_line() {
    ++line_;
    const std::size_t end = std::min(text_.find(line_end_, at_), text_.size());
    const std::string_view line = text_.substr(at_, end - at_);
    at_ = end + 1;
    return line;
  }

  core::Expected<void> damage(const std::string& message) {
    return job_.damage(std::min(at_, text_.size()), fmt::format("line {}: {}", line_, message));
  }

  core::Expected<void> read_header() {
    constexpr std::string_view kMagic = "CADC_Attributes_File";
    if (text_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
    const std::string_view line = next_line();
    if (!trimmed(line).starts_with(kMagic))
      return core::fail(
          fmt::format("{}: line 1: not an attribute file: expected '{}' at its begin", job_.file(), kMagic));
    const auto take = [&](std::string_view name, std::string_view& word) {
      const std::size_t found = line.find(name);
      if (found == std::string_view::npos) return;
      const std::string_view rest = trimmed(line.substr(found + name.size()));
      if (const std::string_view taken = rest.substr(0, rest.find_first_of(" \t,")); !taken.empty()) word = taken;
    };
    take("start:", words_.start), take(" end:", words_.end), take("name_end:", words_.name_end);
    take("sep:", words_.separator);
    return {};
  }

  core::Expected<void> read_line(std::string_view line) {
    if (line.empty()) return {};
    if (line == words_.end) return close();
    if (line.starts_with(words_.start) && line.size() > words_.start.size() &&
        (line[words_.start.size()] == ' ' || line[words_.start.size()] == '\t'))
      return open(trimmed(line.substr(words_.start.size())));
    while (!line.empty()) {
      const std::size_t end = line.find(words_.separator);
      if (auto read = read_attribute(trimmed(line.substr(0, end))); !read) return read;
      line = end == std::string_view::npos ? std::string_view() : line.substr(end + words_.separator.size());
    }
    return {};
  }

  core::Expected<void> open(std::string_view name) {
    if (open_.size() >= kMaxAttributeDepth) {
      ++skipped_;
      return damage(fmt::format("expected elements to nest at most {} deep", kMaxAttributeDepth));
    }
    elements_.push_back({name, open_.empty() ? core::kNone : open_.back(), {}});
    open_.push_back(std::uint32_t(elements_.size() - 1));
    return {};
  }

  core::Expected<void> close() {
    if (skipped_ > 0) {
      --skipped_;
      return {};
    }
    if (open_.empty()) return damage(fmt::format("'{}' without '{}'", words_.end, words_.start));
    open_.pop_back();
    return {};
  }

  core::Expected<void> read_attribute(std::string_view text) {
    if (text.empty()) return {};
    const std::size_t end = text.find(words_.name_end);
    if (end == std::string_view::npos || end == 0 || open_.empty())
      return damage(fmt::format("expected 'key{} value' within an element", words_.name_end));
    if (skipped_ > 0) return {};
    std::vector<Attribute>& attributes = elements_[open_.back()].attributes;
    if (attributes.size() >= kMaxAttributesPerElement)
      return damage(fmt::format("expected at most {} attributes of one element", kMaxAttributesPerElement));
    attributes.push_back({trimmed(text.substr(0, end)), unquoted(trimmed(text.substr(end + words_.name_end.size())))});
    return {};
  }

  std::string_view text_;
  ImportJob& job_;
  char line_end_;  // a file has one of LF and CR alone, or both together
  Words words_;
  std::vector<AttributeElement> elements_;
  std::vector<std::uint32_t> open_;
  std::size_t at_ = 0, line_ = 0, skipped_ = 0;  // skipped_: open elements that were nested too deep
};

/// Groups by the group above and their name, in order of appearance.
class GroupIndex {
 public:
  /// Indexes everything below the file nodes. Node names must not change meanwhile.
  GroupIndex(const core::Scene& scene, std::span<const core::NodeId> files) {
    for (const core::NodeId file : files)
      scene.for_each_node(file, [&](core::NodeId node, const core::Affine&, bool, std::uint32_t, core::MaterialId) {
        if (node == file) return;
        const core::NodeId above = scene.parent(node);
        groups_.push_back({above == file ? core::kNone : above.index, scene.name(node), node, false});
      });
    std::stable_sort(groups_.begin(), groups_.end(), [](const Group& a, const Group& b) { return a.key() < b.key(); });
  }

  /// The next group of that name not yet taken. `above`: invalid for top groups.
  core::NodeId take(core::NodeId above, std::string_view name) {
    const std::tuple key(above.index, name);
    auto group = std::lower_bound(groups_.begin(), groups_.end(), key,
                                  [](const Group& g, const auto& k) { return g.key() < k; });
    // Groups of the same name that were taken come first. The first one counts them.
    if (group == groups_.end() || group->key() != key) return {};
    auto next = group + group->taken;
    if (next == groups_.end() || next->key() != key) return {};
    ++group->taken;
    return next->node;
  }

 private:
  struct Group {
    std::uint32_t above;
    std::string_view name;
    core::NodeId node;
    std::ptrdiff_t taken;
    std::tuple<std::uint32_t, std::string_view> key() const { return {above, name}; }
  };
  std::vector<Group> groups_;
};

/// The file nodes that an attribute file may belong to.
std::vector<core::NodeId> files_for(const core::Scene& scene, core::NodeId parent, core::NodeId except,
                                    const std::string& stem) {
  std::vector<core::NodeId> all, same_stem;
  for (core::NodeId node = scene.first_child(parent); node.valid(); node = scene.next_sibling(node)) {
    if (node == except) continue;
    all.push_back(node);
    if (core::platform::path_of(scene.name(node)).stem() == core::platform::path_of(stem)) same_stem.push_back(node);
  }
  return same_stem.empty() ? all : same_stem;
}

/// Each element's group; invalid for none. Children of an element above all groups are matched with the top groups.
std::vector<core::NodeId> match(const std::vector<AttributeElement>& elements, GroupIndex& groups) {
  std::vector<core::NodeId> group_of(elements.size());
  std::vector<bool> above_all(elements.size(), false);
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const std::uint32_t parent = elements[i].parent;
    const bool at_top = parent == core::kNone || above_all[parent];
    if (!at_top && !group_of[parent].valid()) continue;
    group_of[i] = groups.take(at_top ? core::NodeId{} : group_of[parent], elements[i].name);
    above_all[i] = at_top && !group_of[i].valid();
  }
  return group_of;
}

}  // namespace

core::Expected<ImportReport> read_rvm_attributes(std::span<const std::byte> bytes, const std::filesystem::path& path,
                                                 core::Scene& scene, core::NodeId parent,
                                                 const ImportOptions& options) {
  const std::string file = path.filename().string();
  auto report = run_import(file, scene, parent, options, {}, [&](ImportJob& job) -> core::Expected<void> {
    job.report().bytes = bytes.size();
    std::string decoded;
    const auto utf8 = without_utf16(job, bytes, decoded);
    const std::string_view text(reinterpret_cast<const char*>(utf8.data()), utf8.size());
    const auto elements = AttributeText(as_utf8(job, text, "the text", decoded), job).parse();
    if (!elements) return tl::unexpected(elements.error());
    GroupIndex groups(scene, files_for(scene, parent, job.file_node(), path.stem().string()));
    const std::vector<core::NodeId> group_of = match(*elements, groups);
    if (std::none_of(group_of.begin(), group_of.end(), [](core::NodeId group) { return group.valid(); }))
      return core::fail(
          fmt::format("{}: none of its {} elements is a group of a model read before", file, elements->size()));
    if (auto asked = job.progress(0.9); !asked) return asked;
    for (std::size_t i = 0; i < group_of.size(); ++i) {
      if (!group_of[i].valid()) continue;
      ++job.report().attributed;
      for (const Attribute& attribute : (*elements)[i].attributes)
        scene.set_attribute(group_of[i], attribute.key, attribute.value);
    }
    return {};
  });
  if (!report) return report;
  scene.remove_node(report->nodes[0]);
  report->nodes.clear();
  return report;
}

}  // namespace sightline::importers
