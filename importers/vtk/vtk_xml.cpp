#include "sightline/importers/vtk/internal/vtk_xml.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>

#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkFieldData.h>
#include <vtkLZ4DataCompressor.h>
#include <vtkMultiPieceDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnsignedCharArray.h>
#include <vtkZLibDataCompressor.h>

#include "sightline/importers/internal/base64.h"
#include "sightline/importers/internal/text_scanner.h"
#include "sightline/importers/vtk/internal/vtk_grid.h"

namespace sightline::importers {
namespace {

/// Builds the tree tag by tag.
class XmlParser {
 public:
  explicit XmlParser(const VtkFile& file) : file_(file), text_(as_text(file.bytes)) {}

  XmlTree run() {
    while (!done_) {
      const std::size_t tag = text_.find('<', at_);
      if (tag == std::string_view::npos) file_.fail(text_.size(), "expected the end of the root element");
      at_ = tag + 1;
      starts("!--") ? skip("-->") : starts("?") ? skip("?>") : starts("/") ? close(tag) : open();
    }
    return std::move(tree_);
  }

 private:
  struct Open {
    std::uint32_t element, last_child;
  };

  bool starts(std::string_view with) const { return text_.substr(at_, with.size()) == with; }

  void skip(std::string_view end) {
    at_ = text_.find(end, at_);
    if (at_ == std::string_view::npos) file_.fail(text_.size(), fmt::format("expected '{}'", end));
    at_ += end.size();
  }

  std::string_view name() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && !is_space(text_[at_]) &&
           std::string_view("=/><\"'").find(text_[at_]) == std::string_view::npos)
      ++at_;
    return text_.substr(begin, at_ - begin);
  }
  void skip_space() {
    while (at_ < text_.size() && is_space(text_[at_])) ++at_;
  }

  void close(std::size_t tag) {
    ++at_;
    const std::string_view closed = name();
    skip_space();
    if (open_.empty() || tree_[open_.back().element].name != closed || !starts(">"))
      file_.fail(tag, fmt::format("found the end of '{}', which is not open here", closed.substr(0, 40)));
    ++at_;
    tree_[open_.back().element].end = tag;
    open_.pop_back();
    done_ = open_.empty();
  }

  void open() {
    XmlElement element;
    element.name = name();
    if (element.name.empty() || element.name[0] == '!') file_.fail(at_, "expected an element");
    for (skip_space(); !starts(">") && !starts("/>"); skip_space()) {
      const std::string_view key = name();
      skip_space();
      if (key.empty() || !starts("=")) file_.fail(at_, "expected an attribute, '>' or '/>'");
      ++at_;
      skip_space();
      const char quote = at_ < text_.size() ? text_[at_] : '\0';
      const std::size_t end = quote == '"' || quote == '\'' ? text_.find(quote, at_ + 1) : std::string_view::npos;
      if (end == std::string_view::npos) file_.fail(at_, "expected an attribute's value in quotes");
      if (element.attributes.size() == kMostXmlAttributes)
        file_.fail(at_, fmt::format("expected at most {} attributes of an element", kMostXmlAttributes));
      element.attributes.emplace_back(key, text_.substr(at_ + 1, end - at_ - 1));
      at_ = end + 1;
    }
    const bool empty = starts("/>");
    at_ += empty ? 2 : 1;
    element.begin = element.end = at_;
    add(std::move(element), empty);
  }

  void add(XmlElement element, bool empty) {
    const bool appended = element.name == "AppendedData";
    const auto index = std::uint32_t(tree_.size());
    if (!open_.empty()) {
      Open& parent = open_.back();
      (parent.last_child == core::kNone ? tree_[parent.element].first_child : tree_[parent.last_child].next) = index;
      parent.last_child = index;
    }
    tree_.push_back(std::move(element));
    if (appended) tree_.back().end = text_.size();
    done_ = appended || (empty && open_.empty());
    if (empty || appended) return;
    if (open_.size() == kDeepestXml)
      file_.fail(at_, fmt::format("expected at most {} levels of elements", kDeepestXml));
    open_.push_back({index, core::kNone});
  }

  const VtkFile& file_;
  const std::string_view text_;
  std::size_t at_ = 0;
  XmlTree tree_;
  std::vector<Open> open_;
  bool done_ = false;
};

// --- arrays ----------------------------------------------------------------------------------------------------------

/// Reads bytes from raw data or from base64. Base64 is padded wherever a writer ended one stretch and began the next.
class ByteStream {
 public:
  ByteStream(std::string_view text, bool base64) : text_(text), base64_(base64) {
    while (base64_ && at_ < text_.size() && is_space(text_[at_])) ++at_;
  }

  /// Most bytes that may follow.
  std::size_t rest() const { return base64_ ? (text_.size() - at_) / 4 * 3 + held_ : text_.size() - at_; }

  bool read(std::byte* to, std::size_t count) {
    if (count > rest()) return false;
    if (!base64_) {
      if (count > 0) std::memcpy(to, text_.data() + at_, count);  // an array of none may have no memory
      at_ += count;
      return true;
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (held_ == 0 && !next_group()) return false;
      to[i] = group_[3 - held_--];
    }
    return true;
  }

  /// Ends a stretch: what is left of its last group is padding.
  void end_stretch() { held_ = 0; }

 private:
  bool next_group() {
    if (text_.size() - at_ < 4) return false;
    std::uint32_t bits = 0;
    std::size_t padding = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const char c = text_[at_ + i];
      const int value = kBase64Values[static_cast<unsigned char>(c)];
      if (c == '=' && i >= 2)
        ++padding;
      else if (value < 0 || padding > 0)
        return false;
      bits = bits << 6 | std::uint32_t(std::max(value, 0));
    }
    at_ += 4;
    held_ = 3 - padding;
    // Kept at the end, from 3 - held_ on.
    for (std::size_t i = 0; i < held_; ++i) group_[3 - held_ + i] = std::byte(bits >> (16 - 8 * i) & 0xff);
    return true;
  }

  std::string_view text_;
  bool base64_;
  std::size_t at_ = 0, held_ = 0;
  std::array<std::byte, 3> group_{};
};

std::optional<Number> number_named(std::string_view type) {
  constexpr std::pair<std::string_view, Number> kNames[] = {
      {"Int8", Number::kInt8},     {"UInt8", Number::kUint8},    {"Int16", Number::kInt16}, {"UInt16", Number::kUint16},
      {"Int32", Number::kInt32},   {"UInt32", Number::kUint32},  {"Int64", Number::kInt64}, {"UInt64", Number::kUint64},
      {"Float32", Number::kFloat}, {"Float64", Number::kDouble}, {"String", Number::kInt8}};
  for (const auto& [name, number] : kNames)
    if (name == type) return number;
  return {};
}

using Array = vtkSmartPointer<vtkDataArray>;

class XmlReader {
 public:
  XmlReader(VtkFile& file, const XmlTree& tree) : file_(file), tree_(tree) {}

  vtkSmartPointer<vtkDataObject> run() {
    const XmlElement& root = tree_[0];
    if (root.name != "VTKFile") file_.fail(0, "not a VTK file: expected a VTKFile element");
    const std::string_view type = root.attribute("type");
    if (type != "PolyData" && type != "UnstructuredGrid")
      file_.fail(0, fmt::format("expected type PolyData or UnstructuredGrid, found '{}'", type.substr(0, 40)));
    encoding(root);
    const XmlElement* data = child(root, type);
    if (!data) file_.fail(root.begin, fmt::format("expected an element {}", type));
    std::vector<vtkSmartPointer<vtkDataSet>> pieces;
    for (std::uint32_t i = data->first_child; i != core::kNone; i = tree_[i].next) {
      if (tree_[i].name != "Piece") continue;
      pieces.push_back(type == "PolyData" ? polygons(tree_[i]) : grid(tree_[i]));
    }
    vtkSmartPointer<vtkDataObject> whole;
    if (pieces.size() == 1) {
      whole = pieces[0];
    } else {
      vtkNew<vtkMultiPieceDataSet> several;
      for (unsigned i = 0; i < pieces.size(); ++i) several->SetPiece(i, pieces[i]);
      whole = several;
    }
    if (const XmlElement* fields = child(*data, "FieldData")) field_data(*fields, *whole);
    return whole;
  }

 private:
  const XmlElement* child(const XmlElement& of, std::string_view name) const {
    for (std::uint32_t i = of.first_child; i != core::kNone; i = tree_[i].next)
      if (tree_[i].name == name) return &tree_[i];
    return nullptr;
  }
  const XmlElement* named(const XmlElement* of, std::string_view name) const {
    for (std::uint32_t i = of ? of->first_child : core::kNone; i != core::kNone; i = tree_[i].next)
      if (tree_[i].attribute("Name") == name) return &tree_[i];
    return nullptr;
  }

  void encoding(const XmlElement& root) {
    big_endian_ = root.attribute("byte_order") == "BigEndian";
    wide_header_ = root.attribute("header_type") == "UInt64";
    const std::string_view compressor = root.attribute("compressor");
    if (compressor == "vtkZLibDataCompressor") compressor_ = vtkSmartPointer<vtkZLibDataCompressor>::New();
    if (compressor == "vtkLZ4DataCompressor") compressor_ = vtkSmartPointer<vtkLZ4DataCompressor>::New();
    if (!compressor.empty() && !compressor_)
      file_.fail(0, fmt::format("expected zlib or LZ4 compression, found '{}'", compressor.substr(0, 40)));
    const XmlElement* appended = child(root, "AppendedData");
    if (!appended) return;
    appended_begin_ = as_text(file_.bytes).find('_', appended->begin);
    appended_base64_ = appended->attribute("encoding") != "raw";
    if (appended_begin_ == std::string_view::npos) file_.fail(appended->begin, "expected '_' before appended data");
    ++appended_begin_;
  }

  void count(const XmlElement& piece, std::string_view key, std::uint64_t& value) const {
    const std::string_view found = piece.attribute(key);
    value = 0;
    // Further than files reach; products with small numbers then fit.
    if ((found.empty() || parse_count(found, value)) && value <= std::uint64_t{1} << 40) return;
    file_.fail(piece.begin, fmt::format("expected {} to be a number, found '{}'", key, found.substr(0, 40)));
  }

  // --- an array -----------------------------------------------------------------------------------------------------
  /// Reads an array. Without `count`: as many values as there are.
  Array array(const XmlElement& element, Wanted wanted, std::optional<std::uint64_t> count) {
    const auto number = number_named(element.attribute("type"));
    if (!number)
      file_.fail(element.begin,
                 fmt::format("expected a type of numbers, found '{}'", element.attribute("type").substr(0, 40)));
    const std::string_view format = element.attribute("format");
    Array read = format == "appended" ? appended(element, wanted, *number, count)
                 : format == "binary" ? binary(inside(element), true, element.begin, wanted, *number, count)
                                      : ascii(element, wanted, *number, count);
    file_.progress(element.end);
    return read;
  }

  std::string_view inside(const XmlElement& element) const {
    return as_text(file_.bytes).substr(element.begin, element.end - element.begin);
  }

  Array made(std::size_t at, Wanted wanted, Number number, std::uint64_t count) {
    file_.claim(at, count, sizeof(double));
    Array array = make_array(wanted, number, std::size_t(count));
    if (!array) file_.fail(at, "expected an array of another type of numbers");
    return array;
  }

  Array ascii(const XmlElement& element, Wanted wanted, Number number, std::optional<std::uint64_t> count) {
    const std::string_view text = inside(element);
    if (!count) {
      count = 0;
      for (std::size_t at = 0; !next_word(text, at).empty();) ++*count;
    }
    if (*count > (text.size() + 1) / 2)
      file_.fail(element.begin,
                 fmt::format("expected {} values, found text for {} at most", *count, (text.size() + 1) / 2));
    Array array = made(element.begin, wanted, number, *count);
    fill_from_text(*array, text, file_, element.begin);
    return array;
  }

  Array appended(const XmlElement& element, Wanted wanted, Number number, std::optional<std::uint64_t> count) {
    std::uint64_t offset = 0;
    const std::size_t rest = appended_begin_ == 0 ? 0 : file_.bytes.size() - appended_begin_;
    if (!parse_count(element.attribute("offset"), offset) || offset >= rest)
      file_.fail(element.begin, fmt::format("expected an offset within {} bytes of appended data, found '{}'", rest,
                                            element.attribute("offset").substr(0, 40)));
    const std::size_t begin = appended_begin_ + std::size_t(offset);
    return binary(as_text(file_.bytes).substr(begin), appended_base64_, begin, wanted, number, count);
  }

  bool word(ByteStream& stream, std::uint64_t& value) const {
    std::array<std::byte, 8> raw{};
    const std::size_t width = wide_header_ ? 8 : 4;
    if (!stream.read(raw.data(), width)) return false;
    value = 0;
    for (std::size_t i = 0; i < width; ++i) value = value << 8 | std::uint64_t(raw[big_endian_ ? i : width - 1 - i]);
    return true;
  }

  Array binary(std::string_view text, bool base64, std::size_t at, Wanted wanted, Number number,
               std::optional<std::uint64_t> count) {
    ByteStream stream(text, base64);
    const std::vector<std::byte> content = compressor_ ? inflated(stream, at) : plain(stream, at);
    const std::uint64_t held = content.size() / size_of(number);
    if (count.value_or(held) > held) file_.fail(at, fmt::format("expected {} values, found {}", *count, held));
    Array array = made(at, wanted, number, count.value_or(held));
    fill_from_raw(*array, number, content, big_endian_);
    return array;
  }

  /// Reads uncompressed data: number of bytes, bytes.
  std::vector<std::byte> plain(ByteStream& stream, std::size_t at) {
    std::uint64_t size = 0;
    if (!word(stream, size) || size > stream.rest())
      file_.fail(at, fmt::format("expected an array within the file, found one of {} bytes", size));
    file_.claim(at, size, 1);
    std::vector<std::byte> content(size);
    if (!stream.read(content.data(), content.size())) file_.fail(at, "expected base64");
    return content;
  }

  /// Reads compressed data: number of blocks, size of all but the last, size of the last (0: as the others), compressed
  /// sizes; blocks.
  std::vector<std::byte> inflated(ByteStream& stream, std::size_t at) {
    std::uint64_t blocks = 0, size = 0, last = 0;
    const auto header_damaged = [&] { file_.fail(at, "expected the sizes of compressed blocks"); };
    if (!word(stream, blocks)) header_damaged();
    if (blocks == 0) return std::vector<std::byte>();
    if (!word(stream, size) || !word(stream, last) || blocks > std::min<std::uint64_t>(stream.rest() / 4, kFar))
      header_damaged();
    if (last == 0) last = size;
    if (size > kFar || last > kFar) header_damaged();
    const std::uint64_t total = (blocks - 1) * size + last;
    file_.claim(at, total, 1);
    std::vector<std::uint64_t> packed_sizes(blocks);
    for (std::uint64_t& packed : packed_sizes)
      if (!word(stream, packed)) header_damaged();
    stream.end_stretch();
    std::vector<std::byte> content(total), packed;
    std::size_t done = 0;
    for (std::uint64_t b = 0; b < blocks; ++b) {
      const auto block = std::size_t(b + 1 < blocks ? size : last);
      if (packed_sizes[b] > stream.rest()) header_damaged();
      packed.resize(std::size_t(packed_sizes[b]));
      if (!stream.read(packed.data(), packed.size())) header_damaged();
      const auto* from = reinterpret_cast<const unsigned char*>(packed.data());
      auto* to = reinterpret_cast<unsigned char*>(content.data() + done);
      if (packed.empty() || block == 0 || compressor_->Uncompress(from, packed.size(), to, block) != block)
        file_.fail(at, fmt::format("compressed block {} is damaged", b));
      done += block;
      file_.progress(at);
    }
    return content;
  }

  // --- structure ----------------------------------------------------------------------------------------------------
  vtkSmartPointer<vtkPoints> points(const XmlElement& piece, std::uint64_t& number) {
    count(piece, "NumberOfPoints", number);
    const XmlElement* holder = child(piece, "Points");
    if (!holder || holder->first_child == core::kNone) {
      if (number > 0) file_.fail(piece.begin, "expected an array of points");
      return vtkSmartPointer<vtkPoints>::New();
    }
    return make_points(*array(tree_[holder->first_child], Wanted::kPoints, 3 * number));
  }

  vtkSmartPointer<vtkTypeInt64Array> ids(const XmlElement& element, std::optional<std::uint64_t> count) {
    return vtkTypeInt64Array::SafeDownCast(array(element, Wanted::kIds, count));
  }
  /// Reads an array of ids; null when there is no such element.
  vtkSmartPointer<vtkTypeInt64Array> ids(const XmlElement* holder, std::string_view name,
                                         std::optional<std::uint64_t> count) {
    const XmlElement* element = named(holder, name);
    return element ? ids(*element, count) : nullptr;
  }

  vtkSmartPointer<vtkCellArray> cells(const XmlElement& piece, std::string_view holder_name,
                                      std::string_view count_name, std::uint64_t& number) {
    count(piece, count_name, number);
    const XmlElement* holder = child(piece, holder_name);
    if (number == 0) return vtkSmartPointer<vtkCellArray>::New();
    const auto offsets = ids(holder, "offsets", number);
    if (!offsets) file_.fail(piece.begin, fmt::format("expected {} with offsets of {} cells", holder_name, number));
    return make_cells(file_, holder->begin, offsets, ids(holder, "connectivity", {}), false);
  }

  vtkSmartPointer<vtkDataSet> polygons(const XmlElement& piece) {
    auto data = vtkSmartPointer<vtkPolyData>::New();
    std::uint64_t point_count = 0, cell_count = 0;
    data->SetPoints(points(piece, point_count));
    struct Holder {
      std::string_view name, count;
      void (vtkPolyData::*set)(vtkCellArray*);
    };
    for (const Holder& h : {Holder{"Verts", "NumberOfVerts", &vtkPolyData::SetVerts},
                            Holder{"Lines", "NumberOfLines", &vtkPolyData::SetLines},
                            Holder{"Polys", "NumberOfPolys", &vtkPolyData::SetPolys},
                            Holder{"Strips", "NumberOfStrips", &vtkPolyData::SetStrips}}) {
      std::uint64_t number = 0;
      (data->*h.set)(cells(piece, h.name, h.count, number));
      cell_count += number;
    }
    attributes(piece, *data, point_count, cell_count);
    return data;
  }

  vtkSmartPointer<vtkDataSet> grid(const XmlElement& piece) {
    std::uint64_t point_count = 0, cell_count = 0;
    const auto all_points = points(piece, point_count);
    const auto all_cells = cells(piece, "Cells", "NumberOfCells", cell_count);
    const XmlElement* holder = child(piece, "Cells");
    vtkSmartPointer<vtkTypeInt64Array> found[3];
    const std::pair<std::string_view, std::optional<std::uint64_t>> wanted[] = {
        {"types", cell_count}, {"faces", {}}, {"faceoffsets", cell_count}};
    for (std::size_t i = 0; i < 3 && cell_count > 0; ++i) found[i] = ids(holder, wanted[i].first, wanted[i].second);
    if (!found[0]) found[0] = vtkSmartPointer<vtkTypeInt64Array>::New();
    auto data = make_grid(file_, piece.begin, all_points, *all_cells, *found[0], {found[1], found[2]});
    attributes(piece, *data, point_count, cell_count);
    return data;
  }

  /// Attributes that are damaged are left out when lenient.
  void attributes(const XmlElement& piece, vtkDataSet& data, std::uint64_t point_count, std::uint64_t cell_count) {
    for (const bool of_points : {true, false}) {
      const XmlElement* holder = child(piece, of_points ? "PointData" : "CellData");
      vtkDataSetAttributes* to =
          of_points ? static_cast<vtkDataSetAttributes*>(data.GetPointData()) : data.GetCellData();
      for (std::uint32_t i = holder ? holder->first_child : core::kNone; i != core::kNone; i = tree_[i].next) {
        try {
          attribute(*holder, tree_[i], *to, of_points ? point_count : cell_count);
        } catch (const ImportFault& fault) {
          if (!file_.may_leave_out(fault)) throw;
          file_.job().warn(tree_[i].begin, fault.error.message + "; attribute left out");
        }
      }
    }
  }

  void attribute(const XmlElement& holder, const XmlElement& element, vtkDataSetAttributes& to, std::uint64_t tuples) {
    const std::string_view name = element.attribute("Name"), type = element.attribute("type");
    const std::string_view parts = element.attribute("NumberOfComponents");
    const auto is_active = [&](std::string_view key) { return !name.empty() && holder.attribute(key) == name; };
    const bool normals = parts == "3" && is_active("Normals");
    const bool colours = type == "UInt8" && (parts == "3" || parts == "4");
    if (!normals && !colours) return;
    const int components = parts == "3" ? 3 : 4;
    const Array values =
        array(element, normals ? Wanted::kNormals : Wanted::kBytes, tuples * std::uint64_t(components));
    values->SetNumberOfComponents(components);
    values->SetName(xml_unescaped(name).c_str());
    if (normals)
      to.SetNormals(values);
    else if (is_active("Scalars"))
      to.SetScalars(values);
    else
      to.AddArray(values);
  }

  /// Reads strings: codes of characters, each string ended by a 0.
  void field_data(const XmlElement& fields, vtkDataObject& to) {
    for (std::uint32_t i = fields.first_child; i != core::kNone; i = tree_[i].next) {
      const XmlElement& element = tree_[i];
      if (element.attribute("type") != "String") continue;
      const auto codes = ids(element, {});
      vtkNew<vtkStringArray> strings;
      strings->SetName(xml_unescaped(element.attribute("Name")).c_str());
      std::string value;
      for (vtkIdType k = 0; k < codes->GetNumberOfValues(); ++k) {
        if (const char c = char(codes->GetValue(k)); c != '\0') {
          value += c;
        } else {
          strings->InsertNextValue(value);
          value.clear();
        }
      }
      to.GetFieldData()->AddArray(strings);
    }
  }

  /// Block sizes and numbers of blocks up to this have a product of 64 bits.
  static constexpr std::uint64_t kFar = std::uint64_t{1} << 31;

  VtkFile& file_;
  const XmlTree& tree_;
  bool big_endian_ = false, wide_header_ = false, appended_base64_ = false;
  vtkSmartPointer<vtkDataCompressor> compressor_;
  std::size_t appended_begin_ = 0;
};

}  // namespace

std::string_view XmlElement::attribute(std::string_view key) const {
  for (const auto& [name_of_it, value] : attributes)
    if (name_of_it == key) return value;
  return {};
}

XmlTree parse_xml(const VtkFile& file) {
  return XmlParser(file).run();
}

std::string_view xml_encoding(std::span<const std::byte> file) {
  std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  if (!text.starts_with("<?xml")) return {};
  text = text.substr(0, text.find("?>"));
  constexpr std::string_view kKey = "encoding=";
  const std::size_t key = text.find(kKey);
  if (key == text.npos || key + kKey.size() >= text.size()) return {};
  const char quote = text[key + kKey.size()];
  text.remove_prefix(key + kKey.size() + 1);
  return text.substr(0, text.find(quote));
}

std::string xml_unescaped(std::string_view text) {
  constexpr std::pair<std::string_view, char> kEntities[] = {
      {"&quot;", '"'}, {"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&apos;", '\''}};
  std::string plain;
  while (!text.empty()) {
    const auto* entity = std::find_if(std::begin(kEntities), std::end(kEntities),
                                      [&](const auto& e) { return text.substr(0, e.first.size()) == e.first; });
    const bool found = entity != std::end(kEntities);
    plain += found ? entity->second : text.front();
    text.remove_prefix(found ? entity->first.size() : 1);
  }
  return plain;
}

vtkSmartPointer<vtkDataObject> parse_vtk_xml(VtkFile& file) {
  const XmlTree tree = parse_xml(file);
  return XmlReader(file, tree).run();
}

}  // namespace sightline::importers
