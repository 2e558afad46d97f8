#include "sightline/importers/cad/internal/cad_reader.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <cmath>
#include <exception>
#include <memory>
#include <mutex>
#include <numbers>
#include <thread>
#include <unordered_map>

#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_ProgressIndicator.hxx>
#include <Message_ProgressScope.hxx>
#include <Standard_Failure.hxx>
#include <TColStd_HSequenceOfExtendedString.hxx>
#include <TDF_LabelSequence.hxx>
#include <TopExp_Explorer.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS_TShape.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_GraphNode.hxx>
#include <XCAFDoc_LayerTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sightline/core/internal/disjoint_sets.h"
#include "sightline/importers/cad/internal/cad_document.h"
#include "sightline/importers/cad/internal/cad_messages.h"
#include "sightline/importers/cad/internal/cad_parts.h"
#include "sightline/importers/cad/internal/occt_maths.h"
#include "sightline/importers/internal/import_job.h"
#include "sightline/importers/internal/side_files.h"

namespace sightline::importers {
namespace {

using core::Affine;
using Done = core::Expected<void>;

// Shares of the time.
constexpr double kReading = 0.5, kMeshing = 0.4;

/// Says nothing on the console while it lives.
class Quiet {
 public:
  Quiet() : printers_(Message::DefaultMessenger()->Printers()) {
    Message::DefaultMessenger()->ChangePrinters().Clear();
  }
  ~Quiet() { Message::DefaultMessenger()->ChangePrinters() = printers_; }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  Message_SequenceOfPrinters printers_;
};

/// Tells the import how far Open CASCADE has come, and Open CASCADE when it is cancelled.
class Progress final : public Message_ProgressIndicator {
 public:
  explicit Progress(ImportJob& job) : job_(job) {}
  const Done& done() const { return done_; }

 protected:
  void Show(const Message_ProgressScope&, const Standard_Boolean) override {
    if (done_) done_ = job_.progress(kReading * GetPosition());
  }
  Standard_Boolean UserBreak() override { return !done_; }

 private:
  ImportJob& job_;
  Done done_;
};

/// Whether a name says something to people, unlike those that programs make up for instances: "NAUO12", "12", and those
/// that Open CASCADE makes, "=>[0:1:1:2]".
bool is_telling(const std::string& name) {
  const std::size_t begin = name.starts_with("NAUO") ? 4 : 0;
  return !name.starts_with("=>[") && name.find_first_not_of("0123456789", begin) != std::string::npos;
}

/// Makes the scene of a document.
class Builder {
 public:
  Builder(ImportJob& job, CadDocument& document)
      : job_(job),
        document_(document),
        colours_(XCAFDoc_DocumentTool::ColorTool(document.handle()->Main())),
        layers_(XCAFDoc_DocumentTool::LayerTool(document.handle()->Main())) {}

  Done run() {
    const std::vector<TDF_Label>& tops = document_.roots;
    for (const TDF_Label& top : tops)
      if (auto found = find_parts(top, 1.0, 0); !found) return found;
    if (auto made = make_parts(); !made) return made;
    add_meshes();
    for (const TDF_Label& top : tops)
      if (auto added = add(top, job_.file_node()); !added) return added;
    const auto& items = job_.report().items;
    const bool nothing = std::all_of(items.begin(), items.end(), [](auto count) { return count == 0; });
    if (nothing && !document_.lost_parts.empty())
      return core::fail(
          fmt::format("{}: none of its parts in other files could be read: {}", job_.file(), document_.lost_parts[0]));
    tell();
    return {};
  }

 private:
  static constexpr int kDeepest = 250;           // assemblies in assemblies
  static constexpr double kLarger = 1.0 + 1e-9;  // what rounding does not make of equal scales

  struct Part {
    TDF_Label label;
    CadShape shape;
    CadPart made;
    std::string failure;                            // why it could not be made
    std::vector<std::vector<core::MeshId>> meshes;  // of the contents
    double scale = 1.0;                             // of its largest use
    bool used = false;
  };

  /// The product that a label is a use of. A part in another file is that file's root where it has one, else an assembly of them.
  TDF_Label product_of(const TDF_Label& label) const {
    TDF_Label product;
    if (!XCAFDoc_ShapeTool::GetReferredShape(label, product)) product = label;
    const auto elsewhere = document_.parts_elsewhere.find(entry_of(product));
    const bool one = elsewhere != document_.parts_elsewhere.end() && elsewhere->second.size() == 1 &&
                     !XCAFDoc_ShapeTool::IsReference(elsewhere->second[0]);
    return one ? product_of(elsewhere->second[0]) : product;
  }

  /// The parts of an assembly; none for what is no assembly.
  std::vector<TDF_Label> components_of(const TDF_Label& product) const {
    const auto elsewhere = document_.parts_elsewhere.find(entry_of(product));
    if (elsewhere != document_.parts_elsewhere.end()) return elsewhere->second;
    TDF_LabelSequence components;
    if (XCAFDoc_ShapeTool::IsAssembly(product)) XCAFDoc_ShapeTool::GetComponents(product, components);
    return {components.begin(), components.end()};
  }

  /// Lists each part once, with the scale of its largest use.
  Done find_parts(const TDF_Label& label, double scale, int depth) {
    if (depth > kDeepest)
      return job_.damage(0, fmt::format("assemblies are nested deeper than {}, or within themselves", kDeepest));
    scale *= std::cbrt(std::abs(glm::determinant(placement_of(label).linear)));
    const TDF_Label product = product_of(label);
    const auto [seen, fresh] = seen_.insert({entry_of(product), {}});
    if (!fresh && !(scale > kLarger * seen->second.scale)) return {};
    seen->second.scale = scale;
    if (const std::vector<TDF_Label> components = components_of(product); !components.empty()) {
      for (const TDF_Label& component : components)
        if (auto found = find_parts(component, scale, depth + 1); !found) return found;
      return {};
    }
    if (fresh) {
      seen->second.part = std::uint32_t(parts_.size());
      parts_.push_back({product, shape_of(product, document_, styles_), {}, {}, {}, scale, false});
    }
    parts_[seen->second.part].scale = scale;
    return {};
  }

  /// Within the assembly, or the identity for a product of its own.
  Affine placement_of(const TDF_Label& label) const {
    return label == product_of(label) ? Affine{} : document_.placement(XCAFDoc_ShapeTool::GetLocation(label));
  }

  /// Parts that share a face are one thread's, one after the other: the mesher writes into faces.
  std::vector<std::vector<std::size_t>> apart() const {
    std::unordered_map<const TopoDS_TShape*, std::uint32_t> owner;
    core::DisjointSets sets(parts_.size());
    for (std::uint32_t i = 0; i < parts_.size(); ++i)
      for (const auto& named : parts_[i].shape.bodies)
        for (const StyledFace& face : named.body.faces)
          sets.merge(i, owner.try_emplace(face.face.TShape().get(), i).first->second);
    std::vector<std::vector<std::size_t>> groups(parts_.size());
    for (std::uint32_t i = 0; i < parts_.size(); ++i) groups[sets.find(i)].push_back(i);
    std::erase_if(groups, [](const auto& group) { return group.empty(); });
    return groups;
  }

  /// Says so in the part where it cannot be made.
  void make(Part& part) const {
    const auto fail = [&](const char* what) { part.failure = what && *what ? what : "cannot be meshed"; };
    try {
      part.made = make_part(part.shape, job_.options(), part.scale, document_.shapes_alone);
    } catch (const Standard_Failure& thrown) {
      fail(thrown.GetMessageString());
    } catch (const std::exception& thrown) {
      fail(thrown.what());
    }
    part.made.name = name_of(part.label);
  }

  /// In parallel. A strict import ends with the first part that fails.
  Done make_parts() {
    const auto groups = apart();
    std::atomic<std::size_t> next{0}, finished{0};
    std::atomic<bool> stop{false};
    const auto work = [&] {
      for (std::size_t at = next++; at < groups.size(); at = next++) {
        for (const std::size_t i : groups[at]) {
          if (stop) return;
          make(parts_[i]);
          if (!parts_[i].failure.empty() && !job_.options().lenient) stop = true;
        }
        ++finished;
      }
    };
    const int wanted = job_.options().threads > 0 ? job_.options().threads : int(std::thread::hardware_concurrency());
    const int count = std::clamp(wanted, 1, int(std::max<std::size_t>(1, groups.size())));
    Done done;
    {
      std::vector<std::jthread> threads;
      for (int i = 0; i < count; ++i) threads.emplace_back(work);
      while (done && finished < groups.size() && !stop) {
        done = job_.progress(kReading + kMeshing * double(finished) / double(groups.size()));
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
      if (!done) stop = true;
    }
    const auto failed = std::find_if(parts_.begin(), parts_.end(), [](const Part& p) { return !p.failure.empty(); });
    if (!done || job_.options().lenient || failed == parts_.end()) return done;
    return job_.damage(0, fmt::format("part '{}': {}", failed->made.name, failed->failure));
  }

  core::MaterialId material(std::uint32_t style) {
    if (style == kInherited) return {};
    if (style >= materials_.size()) materials_.resize(styles_.all().size());
    if (!materials_[style].valid()) {
      const CadStyle& look = styles_.all()[style];
      materials_[style] = job_.scene().add_material({"", look.colour, look.alpha});
    }
    return materials_[style];
  }

  void add_meshes() {
    ExactSurfaceReport& report = job_.report().surfaces;
    for (Part& part : parts_) {
      report.parts += part.made.contents.empty() ? 0 : 1;
      for (CadPart::Content& content : part.made.contents) {
        std::vector<core::MeshId>& ids = part.meshes.emplace_back();
        report.analytic_solids += content.primitives.empty() ? 0 : 1;
        report.meshed_bodies += content.primitives.empty() ? 1 : 0;
        report.failed_faces += content.mesh.failed_faces;
        tessellated_ += content.tessellated ? 1 : 0;
        report.deviation = std::max(report.deviation, kMetres * part.scale * content.mesh.deviation);
        for (BodyMesh::OfStyle& of : content.mesh.meshes) {
          of.mesh.name = part.made.name;
          report.triangles += of.mesh.indices.size() / 3;
          auto added = job_.scene().add_mesh(std::move(of.mesh));
          ids.push_back(added.value_or(core::MeshId{}));
        }
      }
      report.curves += part.made.curves;
      report.analytic_deviation =
          std::max(report.analytic_deviation, kMetres * part.scale * part.made.analytic_deviation);
      if (!part.made.contents.empty())
        report.largest_tolerance = std::max(report.largest_tolerance, kMetres * part.scale * part.made.tolerance);
    }
    report.annotations = document_.annotations;
  }

  /// The style of a component, of an assembly's part as seen from above, or of a product.
  std::uint32_t style_of(const TDF_Label& label, const TDF_Label& product) {
    if (path_.Length() > 1) {
      Handle(XCAFDoc_GraphNode) use;
      for (int from = 1; from < path_.Length(); ++from) {
        TDF_LabelSequence chain;
        for (int i = from; i <= path_.Length(); ++i) chain.Append(path_(i));
        if (XCAFDoc_ShapeTool::FindSHUO(chain, use))
          if (const std::uint32_t own = styles_.of(use->Label(), document_); own != kInherited) return own;
      }
    }
    const std::uint32_t own = styles_.of(label, document_);
    return own != kInherited ? own : styles_.of(product, document_);
  }

  void note_attributes(core::NodeId node, const TDF_Label& label, const TDF_Label& product, const std::string& name) {
    core::Scene& scene = job_.scene();
    if (const std::string called = name_of(product); !called.empty() && called != name)
      scene.set_attribute(node, "product", called);
    if (const auto found = document_.attributes.find(entry_of(product)); found != document_.attributes.end())
      for (const auto& [key, value] : found->second) scene.set_attribute(node, key, value);
    for (const TDF_Label& of : {label, product}) {
      Handle(TColStd_HSequenceOfExtendedString) names = layers_->GetLayers(of);
      if (names.IsNull() || names->IsEmpty()) continue;
      std::string all;
      bool visible = false;
      for (const TCollection_ExtendedString& layer : *names) {
        all += (all.empty() ? "" : ", ") + utf8(layer);
        TDF_Label its;
        visible |= !layers_->FindLayer(layer, its) || layers_->IsVisible(its);
      }
      scene.set_attribute(node, "layer", all);
      if (!visible) scene.set_visible(node, false);
      break;
    }
    if (!colours_->IsVisible(label) || !colours_->IsVisible(product)) scene.set_visible(node, false);
  }

  /// Adds a use of a part or an assembly, with all below it.
  Done add(const TDF_Label& label, core::NodeId parent) {
    const TDF_Label product = product_of(label);
    std::string name = name_of(label);
    if (!is_telling(name)) name = name_of(product);
    core::Scene& scene = job_.scene();
    if (scene.node_count() > kMostNodes)
      return core::fail(fmt::format("{}: expected at most {} parts in assemblies", job_.file(), kMostNodes));
    const core::NodeId node = scene.add_node(parent, name, placement_of(label));
    path_.Append(label);
    if (const std::uint32_t style = style_of(label, product); style != kInherited)
      scene.set_material(node, material(style));
    note_attributes(node, label, product, name);
    Done done;
    if (const std::vector<TDF_Label> components = components_of(product); !components.empty()) {
      if (path_.Length() <= kDeepest)
        for (auto at = components.begin(); done && at != components.end(); ++at) done = add(*at, node);
    } else if (const auto found = seen_.find(entry_of(product));
               found != seen_.end() && found->second.part != core::kNone) {
      add_part(parts_[found->second.part], node);
      done = job_.progress(kReading + kMeshing);
    }
    path_.Remove(path_.Length());
    return done;
  }

  void add_part(Part& part, core::NodeId node) {
    job_.report().surfaces.instances += part.made.contents.empty() ? 0 : 1;
    for (std::size_t i = 0; i < part.made.contents.size(); ++i) {
      const CadPart::Content& content = part.made.contents[i];
      const bool named = !content.name.empty() && content.name != part.made.name;
      const bool apart = part.made.contents.size() > 1 && (named || !content.layers.empty() || !content.visible);
      const core::NodeId at = apart ? job_.scene().add_node(node, content.name) : node;
      if (!content.layers.empty()) job_.scene().set_attribute(at, "layer", content.layers);
      if (!content.visible) job_.scene().set_visible(at, false);
      for (const AnalyticPart& primitive : content.primitives)
        job_.add_primitive(at, primitive.primitive, primitive.solid_from_primitive, material(content.style));
      for (std::size_t k = 0; k < content.mesh.meshes.size(); ++k)
        if (part.meshes[i][k].valid())
          job_.add_instance(at, part.meshes[i][k], core::translation(content.mesh.centre),
                            material(content.mesh.meshes[k].style), !part.used);
    }
    part.used = true;
  }

  /// Bodies whose triangles are not what their surfaces are.
  void tell_of_faults() {
    std::uint64_t faces = 0, solids = 0;
    std::string first_face, first_solid;
    const Part* farthest = nullptr;
    for (const Part& part : parts_)
      for (const CadPart::Content& content : part.made.contents) {
        const BodyMesh& mesh = content.mesh;
        const std::string body = content.name.empty() ? "" : fmt::format(" of body '{}'", content.name);
        if (!mesh.wrong_faces.empty() && faces == 0)
          first_face = fmt::format("face {}{} of part '{}'", mesh.wrong_faces[0], body, part.made.name);
        if (mesh.open_edges > 0 && solids == 0)
          first_solid = fmt::format("{} edges{} of part '{}'", mesh.open_edges, body, part.made.name);
        faces += mesh.wrong_faces.size();
        solids += mesh.open_edges > 0 ? 1 : 0;
        if (!content.tessellated && mesh.deviation > part.made.tolerance &&
            (!farthest || deviation(part) > deviation(*farthest)))
          farthest = &part;
      }
    if (faces > 0)
      job_.warn(0, fmt::format("{} faces are meshed with another area than their borders enclose, first {}", faces,
                               first_face));
    if (solids > 0) job_.warn(0, fmt::format("{} solids do not close, first {}", solids, first_solid));
    if (farthest)
      job_.warn(0, fmt::format("triangles lie {:.3g} m off their surfaces in part '{}', where {:.3g} m were asked for",
                               kMetres * farthest->scale * deviation(*farthest), farthest->made.name,
                               kMetres * farthest->scale * farthest->made.tolerance));
  }

  static double deviation(const Part& part) {
    double most = 0.0;
    for (const CadPart::Content& content : part.made.contents) most = std::max(most, content.mesh.deviation);
    return most;
  }

  void tell() {
    const ExactSurfaceReport& report = job_.report().surfaces;
    if (report.failed_faces > 0) {
      const auto worst = std::max_element(parts_.begin(), parts_.end(),
                                          [](const Part& a, const Part& b) { return failures(a) < failures(b); });
      job_.warn(0, fmt::format("{} faces could not be meshed and are left out, most ({}) of part '{}'",
                               report.failed_faces, failures(*worst), worst->made.name));
    }
    const auto left_out = std::count_if(parts_.begin(), parts_.end(), [](const Part& p) { return !p.failure.empty(); });
    if (left_out > 0) job_.warn(0, fmt::format("{} parts could not be meshed and are left out", left_out));
    tell_of_faults();
    if (tessellated_ > 0)
      job_.warn(0,
                fmt::format("{} bodies are tessellated in the file, which does not say how far off their triangles are",
                            tessellated_));
    if (report.curves > 0) job_.warn(0, fmt::format("{} curves are not read", report.curves));
    if (report.annotations > 0)
      job_.warn(0, fmt::format("{} dimensions, tolerances and notes are not read", report.annotations));
    if (document_.units.size() > 1)
      job_.warn(0, fmt::format("parts have different units: {}", fmt::join(document_.units, ", ")));
    job_.report().metres_per_unit = document_.metres_per_unit;
  }

  static std::uint64_t failures(const Part& part) {
    std::uint64_t failed = 0;
    for (const CadPart::Content& content : part.made.contents) failed += content.mesh.failed_faces;
    return failed;
  }

  static constexpr double kMetres = 1e-3;  // a millimetre

  ImportJob& job_;
  CadDocument& document_;
  Handle(XCAFDoc_ColorTool) colours_;
  Handle(XCAFDoc_LayerTool) layers_;
  CadStyles styles_;
  std::vector<core::MaterialId> materials_;  // of the styles
  std::vector<Part> parts_;
  std::uint64_t tessellated_ = 0;  // bodies whose triangles are the file's
  struct Seen {
    std::uint32_t part = core::kNone;  // none: an assembly
    double scale = 0.0;                // of the largest use
  };
  std::unordered_map<std::string, Seen> seen_;  // products by the entry of their label
  TDF_LabelSequence path_;                      // of components, from the top
};

std::string words_of(const Standard_Failure& thrown) {
  return fmt::format("Open CASCADE failed: {} {}", thrown.DynamicType()->Name(), thrown.GetMessageString());
}

/// The document of a file. Its shapes alone where Open CASCADE throws at more.
Done read_document(ImportJob& job, const std::filesystem::path& path, std::unique_ptr<CadDocument>& document,
                   const Message_ProgressRange& progress) {
  constexpr int kFirstTime = 99;  // of a hundred: reading again is rare
  Message_ProgressScope scope(progress, nullptr, kFirstTime + 1);
  try {
    return read_cad_document(job, path, *document, scope.Next(kFirstTime));
  } catch (const Standard_Failure& thrown) {
    if (document->shapes_alone) throw;
    job.warn(0, words_of(thrown) + cad::shapes_alone(path));
  }
  document = std::make_unique<CadDocument>();
  document->shapes_alone = true;
  return read_cad_document(job, path, *document, scope.Next());
}

Done read(ImportJob& job, const std::filesystem::path& path, CadDetail detail) {
  const Quiet quiet;
  const Handle(Progress) progress = new Progress(job);
  try {
    auto document = std::make_unique<CadDocument>();
    document->shapes_alone = detail == CadDetail::kShapesAlone;
    if (auto done = read_document(job, path, document, progress->Start()); !done) return done;
    if (!progress->done()) return progress->done();
    return Builder(job, *document).run();
  } catch (const Standard_Failure& thrown) {
    return core::fail(fmt::format("{}: {}", job.file(), words_of(thrown)));
  }
}

}  // namespace

core::Expected<ImportReport> read_cad(const std::filesystem::path& path, core::Scene& scene, core::NodeId parent,
                                      const ImportOptions& options, CadDetail detail) {
  if (!(options.chord_tolerance >= 0.0 && std::isfinite(options.chord_tolerance)))
    return core::fail(fmt::format("{}: chord_tolerance: expected a finite number of at least 0, found {}",
                                  path.filename().string(), options.chord_tolerance));
  if (!(options.chord_angle > 0.0 && options.chord_angle <= std::numbers::pi))
    return core::fail(fmt::format("{}: chord_angle: expected more than 0 and at most pi, found {}",
                                  path.filename().string(), options.chord_angle));
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  std::vector<std::filesystem::path> side_files;
  ImportOptions frame = options;
  frame.metres_per_unit = 1.0;
  auto report = [&] {
    const SideFileNotes notes(side_files);
    return run_import(path.filename().string(), scene, parent, frame, {1e-3, UpAxis::kZ}, [&](ImportJob& job) {
      std::error_code ignored;
      job.report().bytes = std::filesystem::file_size(path, ignored);
      return read(job, path, detail);
    });
  }();
  if (report) report->side_files = std::move(side_files);
  return report;
}

}  // namespace sightline::importers
