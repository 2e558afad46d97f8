#include "sightline/apps/common/numbers.h"

#include <gtest/gtest.h>

#include "sightline/apps/view/measuring.h"

namespace sightline::apps {
namespace {

TEST(Numbers, LengthsOfPlantsHaveNoDecimals) {
  const LengthFormat plant = length_format(Units::kAutomatic, 120.0, false);
  EXPECT_EQ(plant.text(12.3456), "12,346 mm");
  EXPECT_EQ(plant.text(-1234.5678), "-1,234,568 mm");
  EXPECT_EQ(plant.text(-0.0001), "0 mm");
  EXPECT_EQ(plant.text(core::dvec3(1.0, -0.25, 1000.0)), "1,000  -250  1,000,000");
  EXPECT_EQ(length_format(Units::kAutomatic, 0.5, true).text(0.1234), "123 mm") << "a small part of a plant";
}

TEST(Numbers, SmallModelsHaveMoreDecimals) {
  EXPECT_EQ(length_format(Units::kAutomatic, 10.0, false).text(1.23456), "1,234.6 mm");
  EXPECT_EQ(length_format(Units::kAutomatic, 1.0, false).text(0.123456), "123.46 mm");
  EXPECT_EQ(length_format(Units::kAutomatic, 0.1, false).text(0.0123456), "12.346 mm");
}

TEST(Numbers, UnitsAreAsChosen) {
  EXPECT_EQ(length_format(Units::kMetres, 120.0, true).text(1234.5678), "1,234.568 m");
  EXPECT_EQ(length_format(Units::kFeet, 120.0, true).text(0.3048), "1.000 ft");
  EXPECT_EQ(length_format(Units::kMillimetres, 5.0, false).text(1.0), "1,000.0 mm");
}

TEST(Numbers, AUnitStaysBesideItsNumber) {
  EXPECT_EQ(unbroken("moved by 1,250 mm"), "moved by 1,250\u00a0mm");
  EXPECT_EQ(unbroken("1  2  3"), "1  2  3") << "between numbers a line may end";
}

TEST(Numbers, MeasurementsAreATableForSpreadsheets) {
  const std::vector<Measurement> list{{{1, 2, 3}, {1, 2, 1003}, "corner to edge"}};
  EXPECT_EQ(measurement_table(list, {1, 0, 0}, {Units::kMetres, 1}),
            "no.\tdistance, m\talong x, m\talong y, m\talong z, m\tfrom x, m\tfrom y, m\tfrom z, m\tto x, m\tto y, m\t"
            "to z, m\twhat\n1\t1000.0\t0.0\t0.0\t1000.0\t0.0\t2.0\t3.0\t0.0\t2.0\t1003.0\tcorner to edge\n");
}

}  // namespace
}  // namespace sightline::apps
