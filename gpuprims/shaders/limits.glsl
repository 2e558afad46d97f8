// Constants that C++ and shaders share, in syntax that is valid in both: packing.h and view_block.h include this file.

const int kMaxSections = 8;  // core::kMaxSectionPlanes

// High bits of the material word; the low 24 bits are the row of the material table.
const uint kMaterialMask = 0x00ffffffu;
const uint kBottomOpen = 1u << 24;  // that end is not drawn, but a section still cuts a closed solid
const uint kTopOpen = 1u << 25;
const uint kFlatShaded = 1u << 26;
const uint kVacant = 1u << 27;  // nothing to draw, whatever the placement says
