// The table of a material's numbers.
#include "service/base/material.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <string>

namespace omni::base {
namespace test_base_material {

// Within its range, and no two alike.
double ValueFor(const NumberField<Material>& field, std::size_t i) {
  const double share = 0.2 + 0.6 * static_cast<double>(i) / static_cast<double>(kMaterialFields.size());
  const double value = field.minimum + share * (field.maximum - field.minimum);
  return field.member.whole ? std::round(value) : value;
}

TEST(MaterialFields, KeysAndLabelsAreUnique) {
  std::set<std::string> keys, labels;
  for (const MaterialField& field : kMaterialFields) {
    EXPECT_TRUE(keys.emplace(field.key).second) << field.key;
    EXPECT_TRUE(labels.insert(std::string(field.Group()) + " " + std::string(field.label)).second) << field.key;
    EXPECT_FALSE(field.unit.empty() || field.label.empty()) << field.key;
  }
}

TEST(MaterialFields, DefaultsAreInRange) {
  for (const MaterialField& field : kMaterialFields) {
    EXPECT_LT(field.minimum, field.maximum) << field.key;
    EXPECT_TRUE(field.Contains(field.Default())) << field.key << " " << field.Default();
  }
  EXPECT_EQ(FieldOutOfRange(MaterialParameters{}), kLiveMaterialFields);
}

// Each row writes a member of its own, and reads what it wrote.
TEST(MaterialFields, EachRowAccessesADistinctMember) {
  Material material;
  for (std::size_t i = 0; i < kMaterialFields.size(); ++i)
    kMaterialFields[i].Set(material, ValueFor(kMaterialFields[i], i));
  for (std::size_t i = 0; i < kMaterialFields.size(); ++i)
    EXPECT_EQ(kMaterialFields[i].Get(material), ValueFor(kMaterialFields[i], i)) << kMaterialFields[i].key;
}

// Messages and the layer depend on the order.
TEST(MaterialFields, ParametersFollowTheOrderOfLiveRows) {
  std::array<double, kLiveMaterialFields> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = 1.0 + static_cast<double>(i);
  MaterialParameters parameters;
  static_assert(sizeof(parameters) == sizeof(numbers));
  std::memcpy(static_cast<void*>(&parameters), numbers.data(), sizeof(parameters));
  for (std::size_t i = 0; i < numbers.size(); ++i)
    EXPECT_EQ(parameters.*kLiveFields[i]->live, numbers[i]) << kLiveFields[i]->key;
}

TEST(MaterialFields, ParametersOfReturnsTheLiveNumbers) {
  Material material;
  for (std::size_t i = 0; i < kMaterialFields.size(); ++i)
    kMaterialFields[i].Set(material, ValueFor(kMaterialFields[i], i));
  const MaterialParameters parameters = ParametersOf(material);
  for (const MaterialField* field : kLiveFields) EXPECT_EQ(parameters.*field->live, field->Get(material)) << field->key;
}

TEST(MaterialFields, ClampedIsAlwaysInRange) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  for (const double x : {nan, infinity, -infinity, -1.0, 1e9, 0.0, 0.5}) {
    MaterialParameters parameters;
    for (const MaterialField* field : kLiveFields) parameters.*field->live = x;
    EXPECT_EQ(FieldOutOfRange(Clamped(parameters)), kLiveMaterialFields) << x;
  }
}

TEST(MaterialFields, FieldOutOfRangeFindsTheField) {
  for (std::size_t i = 0; i < kLiveMaterialFields; ++i) {
    for (const double x : {kLiveFields[i]->minimum - 0.01, kLiveFields[i]->maximum * 1.01, std::nan("")}) {
      MaterialParameters parameters;
      parameters.*kLiveFields[i]->live = x;
      EXPECT_EQ(FieldOutOfRange(parameters), i) << kLiveFields[i]->key << " " << x;
    }
  }
}

TEST(FieldCount, CountsMembersOfAnAggregate) {
  struct None {};
  struct Three {
    int a = 1;
    std::array<double, 3> b{};
    Material c;
  };
  EXPECT_EQ(FieldCount<None>(), 0U);
  EXPECT_EQ(FieldCount<Three>(), 3U);
}

}  // namespace test_base_material
}  // namespace omni::base
