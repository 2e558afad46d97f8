// Internal to the importers: VTK's XML files. Their markup becomes a flat tree. Arrays are text in the tree (ascii or
// base64) or lie behind it (appended, raw or base64), plain or compressed by zlib or LZ4.
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
  std::size_t begin = 0, end = 0;  ///< content between its tags, or behind the opening tag of AppendedData

  /// The attribute's value as written, without its quotes; empty when there is none.
  std::string_view attribute(std::string_view key) const;
};
using XmlTree = std::vector<XmlElement>;

inline constexpr std::size_t kDeepestXml = 64, kMostXmlAttributes = 64;

/// Parses markup up to the end of the root element or the begin of AppendedData. Refuses more levels or attributes than
/// above, document types (their entities can grow without bound) and CDATA, by an ImportFault. Memory: at most 50 bytes
/// per byte of markup.
XmlTree parse_xml(const VtkFile& file);

/// "&amp;" to "&".
std::string xml_unescaped(std::string_view text);
/// The encoding that a file's XML declaration names, or empty.
std::string_view xml_encoding(std::span<const std::byte> file);

/// Parses a .vtp or .vtu file (by its root's type) with point normals, colours and strings of field data. Several
/// pieces become a vtkMultiPieceDataSet. LZMA is refused, since its streams determine how much memory they need.
vtkSmartPointer<vtkDataObject> parse_vtk_xml(VtkFile& file);

}  // namespace sightline::importers
