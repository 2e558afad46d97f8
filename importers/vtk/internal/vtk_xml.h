// Internal to the importers: VTK's XML files. Their markup becomes a flat tree; arrays stand in it as text (ascii or
// base64) or behind it (appended, raw or base64), plain or compressed by zlib or LZ4.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/importers/vtk/internal/vtk_file.h"

namespace sightline::importers {

/// Elements in order of appearance; links are indices, core::kNone for none.
struct XmlElement {
  std::string_view name;
  std::vector<std::pair<std::string_view, std::string_view>> attributes;
  std::uint32_t first_child = core::kNone, next = core::kNone;
  std::size_t begin = 0, end = 0;  ///< what stands between its tags, or behind the opening tag of AppendedData

  /// As written, without its quotes; empty when there is none.
  std::string_view attribute(std::string_view key) const;
};
using XmlTree = std::vector<XmlElement>;

inline constexpr std::size_t kDeepestXml = 64, kMostXmlAttributes = 64;

/// Markup up to the end of the root element or the begin of AppendedData. Refused: more levels or attributes than
/// above, document types (their entities can grow without bound) and CDATA. Memory: at most 50 bytes for each of the
/// markup's.
core::Expected<XmlTree> parse_xml(const VtkFile& file);

/// "&amp;" to "&".
std::string xml_unescaped(std::string_view text);

/// A .vtp or .vtu file (by its root's type) with point normals, colours and strings of field data. Several pieces come
/// as a vtkMultiPieceDataSet. LZMA is refused: its streams name the memory that they want.
core::Expected<vtkSmartPointer<vtkDataObject>> parse_vtk_xml(VtkFile& file);

}  // namespace sightline::importers
