#include "sightline/importers/vtk/internal/vtk_reader.h"

#include <algorithm>
#include <map>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "sightline/importers/internal/extension.h"
#include "sightline/importers/internal/file_bytes.h"
#include "sightline/importers/internal/import_job.h"
#include "sightline/importers/internal/side_files.h"
#include "sightline/importers/internal/text_encoding.h"
#include "sightline/importers/vtk/internal/vtk_file.h"
#include "sightline/importers/vtk/internal/vtk_legacy.h"
#include "sightline/importers/vtk/internal/vtk_quiet.h"
#include "sightline/importers/vtk/internal/vtk_scene_builder.h"
#include "sightline/importers/vtk/internal/vtk_xml.h"

namespace sightline::importers {
namespace {

namespace fs = std::filesystem;

bool is_index(const fs::path& path) {
  const std::string extension = lower_case_extension(path);
  return extension == ".vtm" || extension == ".vtmb";
}

/// Reads a file and the files that it names, without recursion: files still to be read wait in a list.
class Reading {
 public:
  Reading(ImportJob& job, const fs::path& model) : job_(job), builder_(job), model_(model) {}

  void run(std::span<const std::byte> bytes) {
    builder_.names().state(xml_encoding(bytes));
    if (!is_index(model_)) return read_data(job_.file_node(), bytes, model_, "", Share{job_});
    std::error_code ignored;
    indices_.push_back({fs::weakly_canonical(model_, ignored), kNoIndex});
    read_index(job_.file_node(), bytes, "", 0);
    while (!waiting_.empty()) {
      const Block block = std::move(waiting_.back());
      waiting_.pop_back();
      read_block(block);
      ++done_;
    }
  }

 private:
  static constexpr std::size_t kNoIndex = ~std::size_t{0};

  /// A .vtm file and the one that named it.
  struct Index {
    fs::path path;
    std::size_t named_by;
  };
  struct Block {
    core::NodeId node;
    std::string file;
    std::size_t named_by;
  };

  void read_data(core::NodeId node, std::span<const std::byte> bytes, const fs::path& path, std::string part,
                 const Share& share) {
    VtkFile file{bytes, std::move(part), share.part(0.0, 0.5)};
    const auto data = lower_case_extension(path) == ".vtk" ? parse_vtk_legacy(file) : parse_vtk_xml(file);
    auto items = builder_.add(node, *data, share.part(0.5, 1.0));
    builder_.forget();
    known_[path] = value_or_throw(std::move(items));
  }

  bool names_itself(const fs::path& path, std::size_t named_by) const {
    for (std::size_t i = named_by; i != kNoIndex; i = indices_[i].named_by)
      if (indices_[i].path == path) return true;
    return false;
  }

  void read_block(const Block& block) {
    const fs::path& index = indices_[block.named_by].path;
    const auto path = find_side_file(index, block.file);
    if (!path) return damage("block " + path.error().message);
    if (const auto known = known_.find(*path); known != known_.end())
      return builder_.add_again(block.node, known->second);
    if (is_index(*path) && names_itself(*path, block.named_by))
      return damage(fmt::format("block '{}' refused: the file names itself", block.file));
    const auto bytes = read_file_bytes(*path);
    if (!bytes) return damage("block " + bytes.error().message);
    job_.report().bytes += bytes->size();
    const double all = double(done_ + 1 + waiting_.size());
    const Share share{job_, double(done_) / all, 1.0 / all};
    const core::ItemId first = core::ItemId(job_.scene().item_slots());
    const std::string kind = lower_case_extension(*path);
    const bool data = kind == ".vtk" || kind == ".vtp" || kind == ".vtu";
    if (!data && !is_index(*path))
      return damage(fmt::format("block '{}' refused: expected .vtk, .vtp, .vtu, .vtm or .vtmb", block.file));
    const VtkFile file{*bytes, block.file + ": ", share};
    try {
      if (data) return read_data(block.node, *bytes, *path, file.part, share);
      indices_.push_back({*path, block.named_by});
      read_index(block.node, *bytes, file.part, indices_.size() - 1);
    } catch (const ImportFault& fault) {
      const bool whole_import = blocks_ > kMaxVtkBlocks || job_.scene().item_slots() != to_index(first);
      if (whole_import || !file.may_leave_out(fault)) throw;
      job_.warn(0, fault.error.message + "; block left out");
    }
  }

  void damage(std::string message) { value_or_throw(job_.damage(0, std::move(message))); }

  /// Makes nodes of an index file's blocks at once, so that they stand in order, and leaves their files for later.
  void read_index(core::NodeId node, std::span<const std::byte> bytes, std::string part, std::size_t index) {
    const VtkFile file{bytes, std::move(part), Share{job_, 0.0, 0.0}};
    const XmlTree tree = parse_xml(file);
    const XmlElement& root = tree[0];
    if (root.name != "VTKFile" || root.attribute("type") != "vtkMultiBlockDataSet")
      file.fail(0, "expected a VTKFile element of type vtkMultiBlockDataSet");
    struct Open {
      std::uint32_t element;
      core::NodeId node;
    };
    std::vector<Block> found;
    std::vector<Open> open;
    if (root.first_child != core::kNone) open.push_back({tree[root.first_child].first_child, node});
    while (!open.empty()) {
      const auto [at, parent] = open.back();
      open.pop_back();
      if (at == core::kNone) continue;
      const XmlElement& element = tree[at];
      open.push_back({element.next, parent});
      const bool data = element.name == "DataSet", pieces = element.name == "Piece";
      const std::string name = xml_unescaped(element.attribute("file"));
      if ((!data && !pieces && element.name != "Block") || (data && name.empty())) continue;
      if (++blocks_ > kMaxVtkBlocks)
        throw ImportFault{{fmt::format("{}: expected at most {} blocks", job_.file(), kMaxVtkBlocks)}};
      const core::NodeId made =
          pieces ? parent
                 : job_.scene().add_node(parent, builder_.names().decode(xml_unescaped(element.attribute("name")), 0));
      if (data) found.push_back({made, name, index});
      open.push_back({element.first_child, made});
    }
    waiting_.insert(waiting_.end(), std::make_move_iterator(found.rbegin()), std::make_move_iterator(found.rend()));
  }

  ImportJob& job_;
  VtkSceneBuilder builder_;
  const fs::path& model_;
  std::vector<Index> indices_;
  std::vector<Block> waiting_;  // the next one last
  std::map<fs::path, VtkSceneBuilder::Items> known_;
  std::size_t blocks_ = 0, done_ = 0;
};

}  // namespace

core::Expected<ImportReport> read_vtk(std::span<const std::byte> bytes, const fs::path& path, core::Scene& scene,
                                      core::NodeId parent, const ImportOptions& options) {
  return run_import(path.filename().string(), scene, parent, options, frame_with_z_up(options), [&](ImportJob& job) {
    job.report().bytes = bytes.size();
    const VtkQuiet quiet;
    std::string decoded;
    Reading(job, path).run(without_utf16(job, bytes, decoded));
    return core::Expected<void>{};
  });
}

}  // namespace sightline::importers
