#include "sightline/importers/cad/internal/step_facts.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>
#include <unordered_map>
#include <vector>

#include <Interface_EntityIterator.hxx>
#include <Interface_Graph.hxx>
#include <STEPConstruct_ExternRefs.hxx>
#include <StepBasic_Document.hxx>
#include <StepBasic_DocumentFile.hxx>
#include <StepBasic_ExternalIdentificationAssignment.hxx>
#include <StepBasic_ExternalSource.hxx>
#include <StepBasic_MeasureValueMember.hxx>
#include <StepBasic_MeasureWithUnit.hxx>
#include <StepBasic_Product.hxx>
#include <StepBasic_ProductDefinition.hxx>
#include <StepBasic_ProductDefinitionFormation.hxx>
#include <StepBasic_ProductDefinitionWithAssociatedDocuments.hxx>
#include <StepBasic_SourceItem.hxx>
#include <StepData_SelectNamed.hxx>
#include <StepData_StepModel.hxx>
#include <StepData_UndefinedEntity.hxx>
#include <StepDimTol_GeometricTolerance.hxx>
#include <StepRepr_DescriptiveRepresentationItem.hxx>
#include <StepRepr_MeasureRepresentationItem.hxx>
#include <StepRepr_NextAssemblyUsageOccurrence.hxx>
#include <StepRepr_ProductDefinitionShape.hxx>
#include <StepRepr_PropertyDefinition.hxx>
#include <StepRepr_PropertyDefinitionRepresentation.hxx>
#include <StepRepr_Representation.hxx>
#include <StepRepr_RepresentationItem.hxx>
#include <StepShape_ConnectedFaceSet.hxx>
#include <StepShape_DimensionalLocation.hxx>
#include <StepShape_DimensionalSize.hxx>
#include <StepShape_ManifoldSolidBrep.hxx>
#include <StepShape_ShapeRepresentation.hxx>
#include <StepShape_ShellBasedSurfaceModel.hxx>
#include <StepShape_SolidModel.hxx>
#include <StepVisual_AnnotationOccurrence.hxx>
#include <StepVisual_Invisibility.hxx>
#include <StepVisual_LayeredItem.hxx>
#include <StepVisual_PresentationLayerAssignment.hxx>
#include <StepVisual_StyledItem.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopoDS_Iterator.hxx>
#include <TransferBRep.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sightline/core/internal/ascii_case.h"
#include "sightline/importers/internal/text_encoding.h"

namespace sightline::importers {
namespace {

std::string text_of(const Handle(TCollection_HAsciiString) & text) {
  return text.IsNull() ? std::string() : utf8_by_guess(text->ToCString());
}

std::optional<double> metres_of_step_unit(const std::string& name) {
  constexpr std::pair<const char*, double> kUnits[] = {
      {"metre", 1.0},       {"meter", 1.0},     {"millimetre", 1e-3},  {"millimeter", 1e-3}, {"centimetre", 1e-2},
      {"centimeter", 1e-2}, {"kilometre", 1e3}, {"micrometre", 1e-6},  {"inch", 0.0254},     {"foot", 0.3048},
      {"mile", 1609.344},   {"mil", 2.54e-5},   {"microinch", 2.54e-8}};
  for (const auto& [known, metres] : kUnits)
    if (core::same_but_for_case(name, known)) return metres;
  return std::nullopt;
}

void note_units(STEPCAFControl_Reader& reader, CadDocument& document) {
  TColStd_SequenceOfAsciiString lengths, angles, solid_angles;
  reader.ChangeReader().FileUnits(lengths, angles, solid_angles);
  const bool first_file = document.units.empty();
  std::optional<double> first;
  for (const TCollection_AsciiString& length : lengths) {
    const std::string name = length.ToCString();
    if (!first) first = metres_of_step_unit(name);
    if (std::find(document.units.begin(), document.units.end(), name) == document.units.end())
      document.units.push_back(name);
  }
  if (first_file) document.metres_per_unit = first.value_or(1e-3);
}

/// An item of a representation as text; empty: of no kind that people read.
std::string value_of(const Handle(StepRepr_RepresentationItem) & item) {
  if (const auto words = Handle(StepRepr_DescriptiveRepresentationItem)::DownCast(item); !words.IsNull())
    return text_of(words->Description());
  const auto measure = Handle(StepRepr_MeasureRepresentationItem)::DownCast(item);
  if (measure.IsNull() || measure->Measure().IsNull() || measure->Measure()->ValueComponentMember().IsNull()) return "";
  char text[32];
  std::snprintf(text, sizeof text, "%.12g", measure->Measure()->ValueComponent());
  return text;
}

/// The part's label that a product's definition has become.
TDF_Label label_of(const Handle(StepBasic_ProductDefinition) & product, STEPCAFControl_Reader& reader,
                   const Handle(XCAFDoc_ShapeTool) & shapes) {
  const Handle(Transfer_TransientProcess)& process = reader.Reader().WS()->TransferReader()->TransientProcess();
  const TopoDS_Shape shape = TransferBRep::ShapeResult(process, product);
  if (shape.IsNull()) return {};
  // Assemblies are not found by their shapes, which are made anew from their parts.
  if (const TDF_Label* label = reader.GetShapeLabelMap().Seek(shape)) return *label;
  TDF_Label label;
  shapes->FindShape(shape, label);
  return label;
}

Handle(StepBasic_ProductDefinition) product_of(const StepRepr_CharacterizedDefinition& of) {
  if (!of.ProductDefinition().IsNull()) return of.ProductDefinition();
  if (of.ProductDefinitionShape().IsNull()) return {};
  return of.ProductDefinitionShape()->Definition().ProductDefinition();
}

void add(core::Scene::Attributes& to, const std::string& key, const std::string& value) {
  if (key.empty() || value.empty()) return;
  const bool known = std::any_of(to.begin(), to.end(), [&](const auto& a) { return a.first == key; });
  if (!known) to.emplace_back(key, value);
}

void note_property(const StepRepr_PropertyDefinitionRepresentation& property, STEPCAFControl_Reader& reader,
                   const Handle(XCAFDoc_ShapeTool) & shapes, CadDocument& document) {
  const Handle(StepRepr_PropertyDefinition) definition = property.Definition().PropertyDefinition();
  const Handle(StepRepr_Representation) values = property.UsedRepresentation();
  if (definition.IsNull() || values.IsNull() || values->Items().IsNull()) return;
  if (definition->IsKind(STANDARD_TYPE(StepRepr_ProductDefinitionShape))) return;  // a shape, not a property
  const Handle(StepBasic_ProductDefinition) product = product_of(definition->Definition());
  if (product.IsNull()) return;
  core::Scene::Attributes found;
  for (int i = 1; i <= values->NbItems(); ++i) {
    const Handle(StepRepr_RepresentationItem) item = values->ItemsValue(i);
    if (item.IsNull()) continue;
    const std::string name = text_of(item->Name());
    add(found, name.empty() ? text_of(definition->Name()) : name, value_of(item));
  }
  if (found.empty()) return;
  const TDF_Label label = label_of(product, reader, shapes);
  if (label.IsNull()) return;
  for (const auto& [key, value] : found) add(document.attributes[entry_of(label)], key, value);
}

/// Attributes that a product states.
void note_product(const Handle(StepBasic_ProductDefinition) & of, STEPCAFControl_Reader& reader,
                  const Handle(XCAFDoc_ShapeTool) & shapes, CadDocument& document) {
  if (of->Formation().IsNull() || of->Formation()->OfProduct().IsNull()) return;
  const Handle(StepBasic_Product) product = of->Formation()->OfProduct();
  const TDF_Label label = label_of(of, reader, shapes);
  if (label.IsNull()) return;
  core::Scene::Attributes& to = document.attributes[entry_of(label)];
  add(to, "part number", text_of(product->Id()));
  add(to, "description", text_of(product->Description()));
  add(to, "version", text_of(of->Formation()->Id()));
}

/// The assignments that identify a document elsewhere.
std::vector<Handle(StepBasic_ExternalIdentificationAssignment)> assignments_of(const Handle(StepBasic_Document) &
                                                                                   document,
                                                                               const Interface_Graph& graph) {
  std::vector<Handle(StepBasic_ExternalIdentificationAssignment)> all;
  Interface_EntityIterator users = graph.Sharings(document);
  for (users.Start(); users.More(); users.Next())
    if (auto by = Handle(StepBasic_ExternalIdentificationAssignment)::DownCast(users.Value()); !by.IsNull())
      all.push_back(by);
  return all;
}

/// A file, or what AP203 associates with a product.
std::vector<Handle(StepBasic_Document)> documents_of(const Handle(StepBasic_DocumentFile) & file,
                                                     const Handle(StepBasic_ProductDefinition) & product) {
  std::vector<Handle(StepBasic_Document)> all;
  if (!file.IsNull()) {
    all.emplace_back(file);
    return all;
  }
  const auto with = Handle(StepBasic_ProductDefinitionWithAssociatedDocuments)::DownCast(product);
  for (int i = 1; !with.IsNull() && !with->DocIds().IsNull() && i <= with->NbDocIds(); ++i)
    if (!with->DocIdsValue(i).IsNull()) all.push_back(with->DocIdsValue(i));
  return all;
}

/// Adds all that may be the name of a document's file, the likeliest first.
void add_file_names(const Handle(StepBasic_Document) & document, const Interface_Graph& graph,
                    std::vector<std::string>& names) {
  const auto add_name = [&](std::string name) {
    if (name.starts_with("file:")) name.erase(0, name.starts_with("file://") ? 7 : 5);
    // "#71" is an entity.
    if (!name.empty() && name[0] != '#' && std::find(names.begin(), names.end(), name) == names.end())
      names.push_back(name);
  };
  for (const auto& assignment : assignments_of(document, graph)) {
    const std::string id = text_of(assignment->AssignedId());
    std::string source;
    if (!assignment->Source().IsNull()) {
      const auto named = Handle(StepData_SelectNamed)::DownCast(assignment->Source()->SourceId().Value());
      constexpr int kText = 6;
      if (!named.IsNull() && named->Kind() == kText && named->String()) source = utf8_by_guess(named->String());
    }
    if (!source.empty() && !id.empty() && source != id) add_name(source + "/" + id);
    add_name(id);
    add_name(source);
  }
  add_name(text_of(document->Id()));
  add_name(text_of(document->Name()));
}

/// Names of solids, shells and what is made of them.
void note_body(const Handle(StepRepr_RepresentationItem) & item, STEPCAFControl_Reader& reader, CadDocument& document) {
  const std::string name = text_of(item->Name());
  if (name.empty()) return;
  const TopoDS_Shape shape =
      TransferBRep::ShapeResult(reader.Reader().WS()->TransferReader()->TransientProcess(), item);
  if (!shape.IsNull()) document.body_names.emplace(shape.TShape().get(), name);
}

/// Layers of bodies: Open CASCADE reads those of whole parts.
void note_layer(const Handle(StepVisual_PresentationLayerAssignment) & layer, STEPCAFControl_Reader& reader,
                CadDocument& document) {
  const Handle(XSControl_WorkSession) session = reader.Reader().WS();
  bool visible = true;
  Interface_EntityIterator users = session->Graph().Sharings(layer);
  for (users.Start(); users.More(); users.Next())
    visible &= !users.Value()->IsKind(STANDARD_TYPE(StepVisual_Invisibility));
  for (int i = 1; !layer->AssignedItems().IsNull() && i <= layer->NbAssignedItems(); ++i) {
    Handle(StepRepr_RepresentationItem) item = layer->AssignedItemsValue(i).RepresentationItem();
    if (const auto styled = Handle(StepVisual_StyledItem)::DownCast(item); !styled.IsNull()) item = styled->Item();
    if (item.IsNull()) continue;
    const TopoDS_Shape shape = TransferBRep::ShapeResult(session->TransferReader()->TransientProcess(), item);
    if (shape.IsNull()) continue;
    BodyLayers& its = document.body_layers[shape.TShape().get()];
    its.names += (its.names.empty() ? "" : ", ") + text_of(layer->Name());
    its.visible |= visible;
  }
}

template <class Array>
std::uint64_t nulls_of(const Handle(Array) & items) {
  std::uint64_t count = 0;
  for (int i = items.IsNull() ? 1 : items->Lower(); !items.IsNull() && i <= items->Upper(); ++i)
    count += items->Value(i).IsNull() ? 1 : 0;
  return count;
}

/// Counts parts of a shape that are not there, or of an unknown type.
std::uint64_t missing_items(const Handle(Standard_Transient) & entity) {
  if (const auto shape = Handle(StepShape_ShapeRepresentation)::DownCast(entity); !shape.IsNull())
    return nulls_of(shape->Items());
  if (const auto shell = Handle(StepShape_ConnectedFaceSet)::DownCast(entity); !shell.IsNull())
    return nulls_of(shell->CfsFaces());
  if (const auto shells = Handle(StepShape_ShellBasedSurfaceModel)::DownCast(entity); !shells.IsNull())
    return nulls_of(shells->SbsmBoundary());
  const auto solid = Handle(StepShape_ManifoldSolidBrep)::DownCast(entity);
  return !solid.IsNull() && solid->Outer().IsNull() ? 1 : 0;
}

/// A missing item costs itself alone.
void warn_of_missing_items(ImportJob& job, const Handle(StepData_StepModel) & model) {
  std::uint64_t missing = 0;
  std::set<std::string> types;
  for (int i = 1; i <= model->NbEntities(); ++i) {
    missing += missing_items(model->Value(i));
    if (const auto entity = Handle(StepData_UndefinedEntity)::DownCast(model->Value(i)); !entity.IsNull())
      types.insert(entity->StepType());
  }
  const bool all_known = types.empty();
  std::erase_if(types, [](const std::string& type) { return type.find("TESSELLATED") != type.npos; });
  if (missing == 0 || (types.empty() && !all_known)) return;
  job.warn(0, fmt::format("{} items of shapes are not read: there is no such entity, or its type is unknown{}", missing,
                          all_known ? "" : fmt::format(" ({})", fmt::join(types, ", "))));
}

}  // namespace

std::vector<ExternalReference> take_external_references(STEPCAFControl_Reader& reader) {
  STEPConstruct_ExternRefs found(reader.Reader().WS());
  found.LoadExternRefs();
  const Interface_Graph& graph = reader.Reader().WS()->Graph();
  std::vector<ExternalReference> references;
  std::vector<Handle(StepBasic_Document)> all;
  std::unordered_map<const void*, std::size_t> known;
  for (int i = 1; i <= found.NbExternRefs(); ++i) {
    const Handle(StepBasic_ProductDefinition) product = found.ProdDef(i);
    const auto documents = documents_of(found.DocFile(i), product);
    all.insert(all.end(), documents.begin(), documents.end());
    if (product.IsNull()) continue;
    const auto [at, added] = known.try_emplace(product.get(), references.size());
    if (added) references.push_back({product, {}});
    for (const Handle(StepBasic_Document) & document : documents)
      add_file_names(document, graph, references[at->second].files);
  }
  const Handle(TCollection_HAsciiString) none = new TCollection_HAsciiString("");
  for (const Handle(StepBasic_Document) & document : all) {
    for (const auto& assignment : assignments_of(document, graph)) {
      assignment->SetAssignedId(none);
      assignment->SetSource({});
    }
    document->SetId(none);
    document->SetName(none);
  }
  return references;
}

TDF_Label empty_part(const ExternalReference& reference, STEPCAFControl_Reader& reader, const CadDocument& document) {
  const TDF_Label label =
      label_of(reference.product, reader, XCAFDoc_DocumentTool::ShapeTool(document.handle()->Main()));
  if (label.IsNull() || XCAFDoc_ShapeTool::IsAssembly(label)) return {};
  const TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(label);
  return !shape.IsNull() && TopoDS_Iterator(shape).More() ? TDF_Label() : label;
}

core::Expected<void> check_step_uses(ImportJob& job, STEPCAFControl_Reader& reader) {
  struct Product {
    double nodes = 1.0;     // with all below it
    std::size_t waits = 0;  // uses of others in it that are not counted yet
    std::vector<const void*> users;
  };
  std::unordered_map<const void*, Product> products;
  const Handle(StepData_StepModel) model = reader.Reader().StepModel();
  for (int i = 1; i <= model->NbEntities(); ++i) {
    const auto use = Handle(StepRepr_NextAssemblyUsageOccurrence)::DownCast(model->Value(i));
    if (use.IsNull() || use->RelatingProductDefinition().IsNull() || use->RelatedProductDefinition().IsNull()) continue;
    const void* user = use->RelatingProductDefinition().get();
    ++products[user].waits;
    products[use->RelatedProductDefinition().get()].users.push_back(user);
  }
  // From the parts upwards. What is used within itself is never reached.
  std::vector<const void*> ready;
  for (const auto& [product, its] : products)
    if (its.waits == 0) ready.push_back(product);
  while (!ready.empty()) {
    const Product& counted = products[ready.back()];
    ready.pop_back();
    if (counted.nodes > double(kMostNodes))
      return core::fail(fmt::format("{}: expected at most {} parts in assemblies", job.file(), kMostNodes));
    for (const void* user : counted.users) {
      products[user].nodes += counted.nodes;
      if (--products[user].waits == 0) ready.push_back(user);
    }
  }
  return {};
}

void note_step_facts(ImportJob& job, STEPCAFControl_Reader& reader, CadDocument& document) {
  note_units(reader, document);
  warn_of_missing_items(job, reader.Reader().StepModel());
  if (document.shapes_alone) return;
  const Handle(XCAFDoc_ShapeTool) shapes = XCAFDoc_DocumentTool::ShapeTool(document.handle()->Main());
  const Handle(StepData_StepModel) model = reader.Reader().StepModel();
  for (int i = 1; i <= model->NbEntities(); ++i) {
    const Handle(Standard_Transient) entity = model->Value(i);
    if (const auto product = Handle(StepBasic_ProductDefinition)::DownCast(entity); !product.IsNull())
      note_product(product, reader, shapes, document);
    else if (const auto property = Handle(StepRepr_PropertyDefinitionRepresentation)::DownCast(entity);
             !property.IsNull())
      note_property(*property, reader, shapes, document);
    else if (const auto layer = Handle(StepVisual_PresentationLayerAssignment)::DownCast(entity); !layer.IsNull())
      note_layer(layer, reader, document);
    else if (entity->IsKind(STANDARD_TYPE(StepShape_SolidModel)) ||
             entity->IsKind(STANDARD_TYPE(StepShape_ConnectedFaceSet)) ||
             entity->IsKind(STANDARD_TYPE(StepShape_ShellBasedSurfaceModel)))
      note_body(Handle(StepRepr_RepresentationItem)::DownCast(entity), reader, document);
    else if (entity->IsKind(STANDARD_TYPE(StepDimTol_GeometricTolerance)) ||
             entity->IsKind(STANDARD_TYPE(StepShape_DimensionalSize)) ||
             entity->IsKind(STANDARD_TYPE(StepShape_DimensionalLocation)) ||
             entity->IsKind(STANDARD_TYPE(StepVisual_AnnotationOccurrence)))
      ++document.annotations;
  }
}

}  // namespace sightline::importers
