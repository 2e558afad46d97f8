#include "sightline/tests/hostile/attack.h"

namespace sightline::hostile::json {
namespace {

Case absurd_number(std::size_t k) {
  const std::vector<std::string> numbers = {"1e999", "-1e308", "1" + repeated("0", 100000), "4.9e-324", "-0"};
  const std::string& n = numbers[k];
  return {{{"model.json", R"({"eye":[0,0,)" + n + R"(],"target":[1,0,0],"fovy_deg":60,"near":)" + n + R"(,"layers":)" +
                              n + R"(,"keys":[{"t":)" + n + R"(,"eye":[0,0,1],"target":[1,0,)" + n +
                              R"(],"fovy_deg":)" + n + "}]}"}}};
}

Case nested(std::size_t k) {
  const std::vector<std::string> opening = {"[", "{\"a\":", "[{\"a\":"};
  return {{{"model.json", repeated(opening[k], 1000000)}}};
}

}  // namespace

std::vector<Attack> attacks() {
  return {{"absurd numbers", 5, absurd_number}, {"deep nesting (1,000,000)", 3, nested}};
}

}  // namespace sightline::hostile::json
