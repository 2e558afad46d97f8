// What C++ and shaders must agree on, in the language that both speak: packing.h and view_block.h include this file.

const int kMaxSections = 8;  // core::kMaxSectionPlanes

// High bits of the material word; the low 24 bits are the row of the material table.
const uint kMaterialMask = 0x00ffffffu;
const uint kBottomOpen = 1u << 24;  // that end is not drawn; the solid is as closed as ever where a section cuts it
const uint kTopOpen = 1u << 25;
const uint kFlatShaded = 1u << 26;
