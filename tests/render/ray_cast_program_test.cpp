// What render/ray_cast.h gives other renderers, without GL; examples/own_renderer.cpp draws with it.
#include <gtest/gtest.h>

#include "sightline/render/ray_cast.h"

namespace sightline::tests::ray_cast_program_test {
namespace {

TEST(RayCastProgram, ProgramsAndRecordsOfAllKindsBelongTogether) {
  for (int i = 0; i < core::kPrimitiveKindCount; ++i) {
    const auto kind = core::Kind(i);
    if (kind == core::Kind::kLine) continue;
    const auto program = render::ray_cast_program(kind);
    ASSERT_TRUE(program) << program.error().message;
    for (const std::string* text : {&program->vertex, &program->fragment}) {
      EXPECT_TRUE(text->starts_with("#version 450 core\n")) << core::name_of(kind);
      EXPECT_EQ(text->find("#include"), std::string::npos) << core::name_of(kind);
    }
    const std::vector<float> ones(std::size_t(core::parameter_count(kind)), 1.0f);
    core::Placement placement;
    placement.origin = {2.0f, 3.0f, 4.0f};
    placement.chunk = 5;
    std::vector<std::uint32_t> records;
    render::append_ray_cast_record(core::make_primitive(kind, ones), placement, 6, 7, records);
    ASSERT_EQ(records.size(), 4 * std::size_t(program->texels_per_record)) << core::name_of(kind);
    EXPECT_EQ(records[12], 5u);
    EXPECT_EQ(records[13], 6u);
    EXPECT_EQ(records[14], 7u);
  }
}

TEST(RayCastProgram, RefusesKindsThatAreNotRayCast) {
  for (const core::Kind kind : {core::Kind::kLine, core::Kind::kFacetGroup, core::Kind::kMesh})
    EXPECT_FALSE(render::ray_cast_program(kind)) << core::name_of(kind);
}

TEST(RayCastProgram, EightVerticesARecord) {
  const std::vector<std::uint32_t> indices = render::ray_cast_indices(2);
  ASSERT_EQ(indices.size(), 36u);
  for (std::size_t i = 0; i < 18; ++i) EXPECT_EQ(indices[18 + i], indices[i] + 8);
}

}  // namespace
}  // namespace sightline::tests::ray_cast_program_test
