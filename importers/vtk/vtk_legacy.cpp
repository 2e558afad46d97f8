#include "sightline/importers/vtk/internal/vtk_legacy.h"

#include <algorithm>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnsignedCharArray.h>

#include "sightline/core/internal/ascii_case.h"
#include "sightline/importers/internal/side_files.h"
#include "sightline/importers/internal/text_scanner.h"
#include "sightline/importers/vtk/internal/vtk_grid.h"

namespace sightline::importers {
namespace {

/// Type of an array's elements: numbers, or bits and strings, which are only skipped or taken as text.
struct Element {
  Number number = Number::kInt8;
  bool bit = false, string = false;
};

std::optional<Element> element_named(std::string_view name) {
  const std::string type = core::lower_case(name);
  if (type == "bit") return Element{.bit = true};
  if (type == "string" || type == "utf8_string") return Element{.string = true};
  if (type == "char" || type == "signed_char") return Element{Number::kInt8};
  if (type == "unsigned_char") return Element{Number::kUint8};
  if (type == "short") return Element{Number::kInt16};
  if (type == "unsigned_short") return Element{Number::kUint16};
  if (type == "int" || type == "vtkidtype") return Element{Number::kInt32};  // ids are written as ints
  if (type == "unsigned_int") return Element{Number::kUint32};
  if (type == "long" || type == "vtktypeint64") return Element{Number::kInt64};
  if (type == "unsigned_long" || type == "vtktypeuint64") return Element{Number::kUint64};
  if (type == "float") return Element{Number::kFloat};
  if (type == "double") return Element{Number::kDouble};
  return {};
}

using Array = vtkSmartPointer<vtkDataArray>;

class LegacyParser {
 public:
  explicit LegacyParser(VtkFile& file) : file_(file), text_(as_text(file.bytes)) {}

  vtkSmartPointer<vtkDataObject> run() {
    header();
    try {
      sections();
    } catch (const ImportFault& fault) {
      if (!file_.may_leave_out(fault) || !whole()) throw;
      file_.job().warn(at_, fault.error.message + "; what follows is left out");
    }
    return assemble();
  }

 private:
  // --- words --------------------------------------------------------------------------------------------------------
  std::string_view word() { return next_word(text_, at_); }
  std::string_view rest_of_line() {
    const std::size_t end = std::min(text_.find(end_of_line_, at_), text_.size());
    const std::string_view line = text_.substr(at_, end - at_);
    at_ = std::min(end + 1, text_.size());
    return !line.empty() && line.back() == '\r' ? line.substr(0, line.size() - 1) : line;
  }
  [[noreturn]] void expected(std::string_view what, std::string_view found) const {
    file_.fail(at_, fmt::format("expected {}, found '{}'", what, found.substr(0, 40)));
  }
  void count(std::uint64_t& value, std::string_view what) {
    const std::string_view found = word();
    if (!parse_count(found, value)) expected(what, found);
  }
  void element(Element& value) {
    const std::string_view found = word();
    const auto known = element_named(found);
    if (!known) expected("a type of numbers (float, int, ...)", found);
    value = *known;
  }

  // --- arrays -------------------------------------------------------------------------------------------------------
  /// Moves to the first value. Fails unless the rest of the file can hold that many values.
  void begin_array(Element element, std::uint64_t count) {
    if (binary_) rest_of_line();
    const std::uint64_t rest = text_.size() - at_;
    std::uint64_t most = (rest + 1) / 2;  // a digit and a space each
    if (binary_) most = element.bit ? rest * 8 : element.string ? rest : rest / size_of(element.number);
    if (element.string) most = rest;
    if (count <= most) return;
    file_.fail(at_,
               fmt::format("expected at most {} values in the rest of the file, found a count of {}", most, count));
  }

  void take(Wanted wanted, Element element, std::uint64_t count, Array& array) {
    begin_array(element, count);
    file_.claim(at_, count, sizeof(double));
    if (!element.bit && !element.string) array = make_array(wanted, element.number, count);
    if (!array) file_.fail(at_, "expected an array of another type of numbers");
    if (!binary_) {
      at_ += fill_from_text(*array, text_.substr(at_), file_, at_);
      return;
    }
    fill_from_raw(*array, element.number, file_.bytes.subspan(at_), true);
    at_ += count * size_of(element.number);
    return file_.progress(at_);
  }

  void skip(Element element, std::uint64_t count) {
    if (element.string) return strings(count, nullptr);
    begin_array(element, count);
    if (binary_) {
      at_ += element.bit ? (count + 7) / 8 : count * size_of(element.number);
      return file_.progress(at_);
    }
    for (std::uint64_t i = 0; i < count; ++i) {
      if (word().empty()) expected("a number", "the end of the file");
      if (i % (1 << 16) == 0) file_.progress(at_);
    }
  }

  void strings(std::uint64_t count, vtkStringArray* to) {
    begin_array({.string = true}, count);
    if (!binary_ && count > 0) rest_of_line();
    for (std::uint64_t i = 0; i < count; ++i) {
      std::string_view value;
      if (binary_) {
        binary_string(value);
      } else {
        if (at_ >= text_.size()) expected("a string", "the end of the file");
        value = rest_of_line();
      }
      if (to && i <= kMaxStrings) to->InsertNextValue(percent_decoded(value));
    }
    return file_.progress(at_);
  }

  /// The two upper bits of the first byte tell how many bytes the length has: 11, 10, 01 for 1, 2, 4.
  void binary_string(std::string_view& value) {
    const std::size_t rest = text_.size() - at_;
    const unsigned kind = rest > 0 ? static_cast<unsigned char>(text_[at_]) >> 6 : 0;
    const std::size_t width = kind == 3 ? 1 : kind == 2 ? 2 : 4;
    if (kind == 0 || width > rest) expected("the length of a string", {});
    std::size_t length = static_cast<unsigned char>(text_[at_]) & 0x3f;
    for (std::size_t i = 1; i < width; ++i) length = length << 8 | static_cast<unsigned char>(text_[at_ + i]);
    if (length > rest - width) expected("a string within the file", {});
    value = text_.substr(at_ + width, length);
    at_ += width + length;
  }

  // --- structure ----------------------------------------------------------------------------------------------------
  void header() {
    constexpr std::string_view kBegin = "# vtk DataFile Version ";
    if (text_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
    const std::size_t end = text_.find_first_of("\r\n", at_);
    if (end != text_.npos && text_[end] == '\r' && text_.substr(end, 2) != "\r\n") end_of_line_ = '\r';
    const std::string_view first = rest_of_line();
    if (first.substr(0, kBegin.size()) != kBegin)
      file_.fail(0, fmt::format("not a VTK file: expected '{}N.N' in its first line", kBegin));
    version_ = first.size() > kBegin.size() ? first[kBegin.size()] - '0' : 0;
    rest_of_line();  // a title
    const std::string_view form = word();
    binary_ = core::lower_case(form) == "binary";
    if (!binary_ && core::lower_case(form) != "ascii") expected("ASCII or BINARY", form);
  }

  void sections() {
    for (std::string_view found = word(); !found.empty(); found = word()) {
      const std::string keyword = core::lower_case(found);
      section(keyword);
    }
    if (!whole()) file_.fail(at_, "expected a DATASET with POINTS and cells before the end of the file");
  }

  void section(const std::string& keyword) {
    if (keyword == "dataset") return data_set();
    if (keyword == "metadata") return metadata();
    if (keyword == "field") return field();
    if (keyword == "points") return points();
    if (keyword == "vertices" || keyword == "lines" || keyword == "polygons" || keyword == "triangle_strips" ||
        keyword == "cells")
      return cells(keyword);
    if (keyword == "cell_types") return types();
    if (keyword == "cell_data" || keyword == "point_data") {
      target_ = keyword == "cell_data" ? cell_data_.Get() : static_cast<vtkDataSetAttributes*>(point_data_.Get());
      return count(tuples_, "a number of tuples");
    }
    return target_ ? attribute(keyword) : expected("a section of a data set", keyword);
  }

  void data_set() {
    const std::string_view found = word();
    grid_ = core::lower_case(found) == "unstructured_grid";
    if (!grid_ && core::lower_case(found) != "polydata") expected("DATASET POLYDATA or UNSTRUCTURED_GRID", found);
    known_ = true;
  }

  /// Skips metadata, which end with an empty line.
  void metadata() {
    rest_of_line();
    while (at_ < text_.size() && !rest_of_line().empty()) {
    }
  }

  void points() {
    std::uint64_t points = 0;
    Element type;
    Array values;
    count(points, "a number of points");
    element(type);
    if (points > text_.size()) expected("fewer points than the file has bytes", std::to_string(points));
    take(Wanted::kPoints, type, 3 * points, values);
    points_ = make_points(*values);
  }

  void cells(const std::string& keyword) {
    std::uint64_t first = 0, size = 0;
    count(first, "a number of cells");
    count(size, "the size of the cells");
    const std::size_t at = at_;
    auto& cells = keyword == "vertices"          ? vertices_
                  : keyword == "lines"           ? lines_
                  : keyword == "triangle_strips" ? strips_
                                                 : cells_;
    cells = version_ >= 5 ? cells_by_offsets(first, size) : cells_by_sizes(first, size, at);
  }

  vtkSmartPointer<vtkCellArray> cells_by_offsets(std::uint64_t offset_count, std::uint64_t size) {
    vtkSmartPointer<vtkDataArray> arrays[2];
    const std::uint64_t counts[] = {offset_count, size};
    const std::string_view names[] = {"offsets", "connectivity"};
    for (std::size_t i = 0; i < 2; ++i) {
      const std::size_t before = at_;
      const std::string_view found = word();
      if (core::lower_case(found) != names[i]) {
        at_ = before;
        if (offset_count == 0) return vtkSmartPointer<vtkCellArray>::New();
        file_.fail(before, fmt::format("expected {} of cells", names[i]));
      }
      Element type;
      element(type);
      take(Wanted::kIds, type, counts[i], arrays[i]);
    }
    return make_cells(file_, at_, vtkTypeInt64Array::SafeDownCast(arrays[0]),
                      vtkTypeInt64Array::SafeDownCast(arrays[1]), true);
  }

  /// Each cell's number of points and its points.
  vtkSmartPointer<vtkCellArray> cells_by_sizes(std::uint64_t cell_count, std::uint64_t size, std::size_t begin) {
    Array array;
    take(Wanted::kIds, {Number::kInt32}, size, array);
    if (cell_count > size) file_.fail(begin, fmt::format("expected at most {} cells, found {}", size, cell_count));
    vtkNew<vtkTypeInt64Array> offsets, connectivity;
    offsets->SetNumberOfTuples(vtkIdType(cell_count + 1));
    connectivity->SetNumberOfTuples(vtkIdType(size - cell_count));
    const vtkTypeInt64* ids = static_cast<vtkTypeInt64Array*>(array.Get())->GetPointer(0);
    vtkTypeInt64* to = connectivity->GetPointer(0);
    std::uint64_t at = 0;
    for (std::uint64_t c = 0; c < cell_count; ++c) {
      offsets->SetValue(vtkIdType(c), vtkTypeInt64(at - c));
      if (at >= size || ids[at] < 0 || std::uint64_t(ids[at]) > size - at - 1 || at - c + ids[at] > size - cell_count)
        file_.fail(begin, fmt::format("expected {} cells in {} numbers, found that cell {} reaches beyond", cell_count,
                                      size, c));
      const auto points = std::uint64_t(ids[at++]);
      to = std::copy_n(ids + at, points, to);
      at += points;
    }
    if (at != size)
      file_.fail(begin, fmt::format("expected {} cells in {} numbers, found them in {}", cell_count, size, at));
    offsets->SetValue(vtkIdType(cell_count), vtkTypeInt64(size - cell_count));
    return make_cells(file_, begin, offsets, connectivity, true);
  }

  void types() {
    std::uint64_t cell_count = 0;
    count(cell_count, "a number of cells");
    return take(Wanted::kIds, {Number::kInt32}, cell_count, types_);
  }

  // --- attributes ---------------------------------------------------------------------------------------------------
  void attribute(const std::string& keyword) {
    if (keyword == "scalars") return scalars();
    if (keyword == "color_scalars") return colour_scalars();
    const std::string_view name = word();
    if (keyword == "lookup_table") {
      std::uint64_t entries = 0;
      count(entries, "the size of a lookup table");
      return skip({Number::kUint8}, std::min(entries, kFar) * 4);
    }
    std::uint64_t components = 0;
    if (keyword == "texture_coordinates") {
      count(components, "a number of components");
    } else if (keyword == "vectors" || keyword == "normals") {
      components = 3;
    } else if (keyword == "tensors" || keyword == "tensors6") {
      components = keyword == "tensors" ? 9 : 6;
    } else if (keyword == "global_ids" || keyword == "pedigree_ids" || keyword == "edge_flags") {
      components = 1;
    } else {
      expected("a section of a data set", keyword + ' ' + std::string(name.substr(0, 20)));
    }
    Element type;
    element(type);
    const std::uint64_t values = std::min(tuples_, kFar) * std::min(components, kFar);
    if (keyword != "normals" || target_ != point_data_.Get()) return skip(type, values);
    Array normals;
    take(Wanted::kNormals, type, values, normals);
    normals->SetNumberOfComponents(3);
    point_data_->SetNormals(normals);
  }

  void scalars() {
    word();  // name
    Element type;
    element(type);
    std::uint64_t components = 1;
    std::size_t in_line = 0;
    const std::string_view line = rest_of_line();
    if (const std::string_view found = next_word(line, in_line); !found.empty() && !parse_count(found, components))
      expected("a number of components", found);
    if (const std::string_view table = word(); core::lower_case(table) != "lookup_table")
      expected("LOOKUP_TABLE after SCALARS", table);
    word();
    return take_colours_or_skip(type, components, tuples_, "", *target_);
  }

  /// Colours are fractions of one in ascii files.
  void colour_scalars() {
    word();  // name
    std::uint64_t components = 0;
    count(components, "a number of components");
    if (binary_) return take_colours_or_skip({Number::kUint8}, components, tuples_, "", *target_);
    const std::uint64_t values = std::min(tuples_, kFar) * std::min(components, kFar);
    if (components != 3 && components != 4) return skip({Number::kFloat}, values);
    Array fractions;
    take(Wanted::kPoints, {Number::kDouble}, values, fractions);
    vtkNew<vtkUnsignedCharArray> colours;
    colours->SetNumberOfComponents(int(components));
    colours->SetNumberOfTuples(vtkIdType(tuples_));
    for (vtkIdType i = 0; i < fractions->GetNumberOfValues(); ++i) {
      const double fraction = fractions->GetComponent(i, 0);
      colours->SetValue(i, static_cast<unsigned char>(fraction > 0.0 ? std::min(fraction, 1.0) * 255.0 + 0.5 : 0.0));
    }
    target_->SetScalars(colours);
  }

  /// Without a name, the colours become the active scalars.
  void take_colours_or_skip(Element type, std::uint64_t components, std::uint64_t tuples, const std::string& name,
                            vtkFieldData& to) {
    const std::uint64_t values = std::min(tuples, kFar) * std::min(components, kFar);
    const bool colours =
        !type.bit && !type.string && type.number == Number::kUint8 && (components == 3 || components == 4);
    if (!colours || !target_) return skip(type, values);
    Array array;
    take(Wanted::kBytes, type, values, array);
    array->SetNumberOfComponents(int(components));
    if (!name.empty()) array->SetName(name.c_str());
    if (name.empty())
      target_->SetScalars(array);
    else
      to.AddArray(array);
  }

  void field() {
    word();  // name
    std::uint64_t arrays = 0;
    count(arrays, "a number of arrays");
    for (std::uint64_t i = 0; i < arrays; ++i) {
      std::string_view name = word();
      if (core::lower_case(name) == "metadata") {  // of the array before
        metadata();
        name = word();
      }
      if (name.empty()) expected("an array", "the end of the file");
      if (name == "NULL_ARRAY") continue;
      std::uint64_t components = 0, tuples = 0;
      Element type;
      count(components, "a number of components");
      count(tuples, "a number of tuples");
      element(type);
      field_array(percent_decoded(name), type, components, tuples);
    }
  }

  void field_array(const std::string& name, Element type, std::uint64_t components, std::uint64_t tuples) {
    if (type.string && !target_) {
      vtkNew<vtkStringArray> values;
      values->SetName(name.c_str());
      strings(std::min(components, kFar) * std::min(tuples, kFar), values);
      fields_->AddArray(values);
      return;
    }
    if (target_) return take_colours_or_skip(type, components, tuples, name, *target_);
    return skip(type, std::min(components, kFar) * std::min(tuples, kFar));
  }

  // --- result -------------------------------------------------------------------------------------------------------
  bool whole() const { return known_ && points_ && (!grid_ || (cells_ && types_)); }

  vtkSmartPointer<vtkDataObject> assemble() {
    vtkSmartPointer<vtkDataSet> data;
    if (grid_) {
      data = make_grid(file_, at_, points_, *cells_, static_cast<vtkTypeInt64Array&>(*types_));
    } else {
      auto polygons = vtkSmartPointer<vtkPolyData>::New();
      polygons->SetPoints(points_);
      if (vertices_) polygons->SetVerts(vertices_);
      if (lines_) polygons->SetLines(lines_);
      if (cells_) polygons->SetPolys(cells_);
      if (strips_) polygons->SetStrips(strips_);
      data = polygons;
    }
    data->GetPointData()->ShallowCopy(point_data_);
    data->GetCellData()->ShallowCopy(cell_data_);
    data->SetFieldData(fields_);
    return data;
  }

  /// Products of counts up to this fit 64 bits; files are shorter.
  static constexpr std::uint64_t kFar = std::uint64_t{1} << 31;
  static constexpr std::uint64_t kMaxStrings = 10000;

  VtkFile& file_;
  const std::string_view text_;
  std::size_t at_ = 0;
  char end_of_line_ = '\n';
  bool binary_ = false, known_ = false, grid_ = false;
  int version_ = 0;

  vtkSmartPointer<vtkPoints> points_;
  vtkSmartPointer<vtkCellArray> vertices_, lines_, cells_, strips_;
  Array types_;
  vtkNew<vtkPointData> point_data_;
  vtkNew<vtkCellData> cell_data_;
  vtkNew<vtkFieldData> fields_;
  vtkDataSetAttributes* target_ = nullptr;  // of POINT_DATA or CELL_DATA
  std::uint64_t tuples_ = 0;
};

}  // namespace

vtkSmartPointer<vtkDataObject> parse_vtk_legacy(VtkFile& file) {
  return LegacyParser(file).run();
}

}  // namespace sightline::importers
