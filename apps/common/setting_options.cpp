#include "sightline/apps/common/setting_options.h"

#include "sightline/engine/internal/settings.h"

namespace sightline::apps {
namespace {

using engine::kAny, engine::kFinite, engine::kMostFloat;

SettingWords words(std::string name, const char* help, double low, double high) {
  std::replace(name.begin(), name.end(), '_', '-');
  return {"--" + name, help, low, high};
}

}  // namespace

const SettingWords& words_of_setting(const std::string& name) {
  static const std::map<std::string, SettingWords> kAll{
#define SIGHTLINE_SETTING(path, name, type, change, low, high, range, initial, help) \
  {#name, words(#name, help, low, high)},
#define SIGHTLINE_UNPAGED_SETTING SIGHTLINE_SETTING
#define SIGHTLINE_ENGINE_SETTING SIGHTLINE_SETTING
#include "sightline/engine/internal/settings.inc"
  };
  return kAll.at(name);
}

}  // namespace sightline::apps
