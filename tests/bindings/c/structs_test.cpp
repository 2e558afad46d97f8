// Structs of other versions: shorter and longer ones, and what of them is refused.
#include <cstring>

#include "c_scene.h"
#include "sightline/bindings/c/internal/values.h"

namespace sightline::tests::structs_test {
namespace {

/// A struct of a later version.
template <class T>
struct Longer {
  T now;
  std::uint64_t added;
};

TEST(CapiStructs, LaterFieldsMustBeZero) {
  const CScene c;
  Longer<sl_material_data> data = {SL_MATERIAL_DATA_INIT, 0};
  data.now.size = sizeof data;
  sl_material material = {0};
  EXPECT_OK(sl_material_add(c.scene, &data.now, &material));
  data.added = std::uint64_t(1) << 63;
  EXPECT_EQ(sl_material_add(c.scene, &data.now, &material), SL_ERROR_UNSUPPORTED);
}

TEST(CapiStructs, LaterResultsAreZero) {
  const CScene c;
  Longer<sl_scene_info> info;
  std::memset(&info, 0xab, sizeof info);
  info.now.size = sizeof info;
  ASSERT_OK(sl_scene_get(c.scene, &info.now));
  EXPECT_EQ(info.now.size, sizeof info);
  EXPECT_EQ(info.now.nodes, 1u);
  EXPECT_EQ(info.added, 0u);
}

TEST(CapiStructs, AStructWithoutItsSizeIsRefused) {
  const CScene c;
  sl_material_data data = SL_MATERIAL_DATA_INIT;
  sl_material material = {0};
  for (const std::uint32_t size : {std::uint32_t(0), std::uint32_t(3), std::uint32_t(sizeof data - 1),
                                   std::uint32_t(1) << 30, ~std::uint32_t(0)}) {
    data.size = size;
    EXPECT_EQ(sl_material_add(c.scene, &data, &material), SL_ERROR_ARGUMENT) << size;
  }
  EXPECT_EQ(sl_material_add(c.scene, nullptr, &material), SL_ERROR_ARGUMENT);
  sl_scene_info info;
  for (const std::uint32_t size : {std::uint32_t(0), std::uint32_t(1) << 30}) {
    info.size = size;
    EXPECT_EQ(sl_scene_get(c.scene, &info), SL_ERROR_ARGUMENT) << size;
  }
}

/// As a struct that has grown since its first version.
struct Grown {
  std::uint32_t size;
  std::int32_t first;
  std::int32_t added;
};

}  // namespace
}  // namespace sightline::tests::structs_test

template <>
inline constexpr std::size_t sightline::capi::kFirstSize<sightline::tests::structs_test::Grown> = 8;

namespace sightline::tests::structs_test {
namespace {

TEST(CapiStructs, EarlierProgramsGetTheDefaultsOfLaterFields) {
  const Grown of_earlier_program = {8, 5, 1234};  // the last field is not there
  const Grown read = capi::read(&of_earlier_program, Grown{sizeof(Grown), 1, 2});
  EXPECT_EQ(read.first, 5);
  EXPECT_EQ(read.added, 2);
  Grown result = {8, 0, 1234};
  capi::write(&result, {0, 7, 9});
  EXPECT_EQ(result.size, 8u);
  EXPECT_EQ(result.first, 7);
  EXPECT_EQ(result.added, 1234) << "not the program's to be written";
}

TEST(CapiStructs, TextsAreCutToTheBuffer) {
  const CScene c;
  const sl_node node = c.add_node(c.root, "valve");
  char buffer[4] = {'x', 'x', 'x', 'x'};
  sl_text text = {buffer, sizeof buffer, 0};
  ASSERT_OK(sl_node_name(c.scene, node, &text));
  EXPECT_STREQ(buffer, "val");
  EXPECT_EQ(text.length, 5u);
  text = {nullptr, 0, 0};
  ASSERT_OK(sl_node_name(c.scene, node, &text));
  EXPECT_EQ(text.length, 5u);
  text = {nullptr, 1, 0};
  EXPECT_EQ(sl_node_name(c.scene, node, &text), SL_ERROR_ARGUMENT);
  EXPECT_EQ(sl_node_name(c.scene, node, nullptr), SL_ERROR_ARGUMENT);
}

TEST(CapiStructs, LongMessagesAreCut) {
  const std::string path(5000, 'a');
  sl_view view = SL_VIEW_INIT;
  EXPECT_NE(sl_view_read(path.c_str(), 1.0, &view), SL_OK);
  EXPECT_LE(std::strlen(sl_last_error()), 1023u);
  EXPECT_GE(std::strlen(sl_last_error()), 40u);
}

TEST(CapiStructs, LayoutsAreThoseOfTheFirstVersion) {
  // Programs are compiled with these. A struct may grow at its end; kFirstSize then keeps this size.
  if constexpr (sizeof(void*) == 8) {
    EXPECT_EQ(sizeof(sl_scene_info), 40u);
    EXPECT_EQ(capi::kFirstSize<sl_node_info>, 184u);
    EXPECT_EQ(sizeof(sl_node_info), 192u);
    EXPECT_EQ(sizeof(sl_mesh_data), 48u);
    EXPECT_EQ(sizeof(sl_material_data), 32u);
    EXPECT_EQ(sizeof(sl_primitive), 40u);
    EXPECT_EQ(sizeof(sl_item_info), 208u);
    EXPECT_EQ(capi::kFirstSize<sl_import_report>, 160u);
    EXPECT_EQ(offsetof(sl_import_report, recognised), 168u);
    EXPECT_EQ(offsetof(sl_import_report, parts), 352u);
    EXPECT_EQ(sizeof(sl_import_report), 440u);
    EXPECT_EQ(sizeof(sl_view), 536u);
    EXPECT_EQ(capi::kFirstSize<sl_frame_report>, 112u);
    EXPECT_EQ(sizeof(sl_frame_report), 136u);
    EXPECT_EQ(sizeof(sl_late_report), 40u);
    EXPECT_EQ(capi::kFirstSize<sl_engine_info>, 56u);
    EXPECT_EQ(offsetof(sl_engine_info, levels_bytes), 64u);
    EXPECT_EQ(sizeof(sl_engine_info), 72u);
    EXPECT_EQ(capi::kFirstSize<sl_loss_report>, 24u);
    EXPECT_EQ(sizeof(sl_loss_report), 64u);
    EXPECT_EQ(sizeof(sl_controller_info), 40u);
    EXPECT_EQ(sizeof(sl_cull_states), 96u);
    EXPECT_EQ(sizeof(sl_cull_box), 56u);
    EXPECT_EQ(sizeof(sl_image_tile), 24u);
    EXPECT_EQ(sizeof(sl_cropped_tile), 40u);
    EXPECT_EQ(sizeof(sl_external_target), 56u);
    EXPECT_EQ(sizeof(sl_item_style), 32u);
    EXPECT_EQ(sizeof(sl_pick), 80u);
    EXPECT_EQ(capi::kFirstSize<sl_ray>, 72u);
    EXPECT_EQ(sizeof(sl_ray), 344u);
    EXPECT_EQ(sizeof(sl_visible_item), 16u);
    EXPECT_EQ(sizeof(sl_paged_report), 136u);
    EXPECT_EQ(sizeof(sl_paged_info), 88u);
  }
}

}  // namespace
}  // namespace sightline::tests::structs_test
