#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>

#include "sightline/tests/hostile/attack.h"
#include "sightline/tests/support/places.h"

namespace sightline::hostile {

namespace fs = std::filesystem;

std::string Target::name() const {
  const bool several = format == "gltf" || format == "vtk" || extension == ".rev";
  return several ? extension.substr(1) : format;
}

std::vector<Target> targets() {
  std::vector<Target> all;
  for (const auto of_format : {
           rvm_targets,
           obj_targets,
#ifdef SIGHTLINE_HAVE_GLTF
           gltf_targets,
#endif
           ply_targets,
           stl_targets,
#ifdef SIGHTLINE_HAVE_SLC
           slc_targets,
#endif
#ifdef SIGHTLINE_HAVE_VTK
           vtk_targets,
#endif
           json_targets,
       })
    std::ranges::move(of_format(), std::back_inserter(all));
  return all;
}

Target target_of(std::string_view name) {
  for (Target& target : targets())
    if (target.name() == name) return target;
  std::abort();
}

Case one_file(std::string name, std::string content) {
  Case made;
  made.files.push_back({std::move(name), std::move(content)});
  return made;
}

Case refused(Case made) {
  made.strict = made.lenient = Expect::kFailure;
  return made;
}

Case damaged(Case made) {
  made.strict = Expect::kFailure;
  made.lenient = Expect::kSuccess;
  return made;
}

Case sound(Case made) {
  made.strict = made.lenient = Expect::kSuccess;
  return made;
}

std::string repeated(const std::string& text, std::size_t times, const std::string& separator) {
  std::string all;
  all.reserve((text.size() + separator.size()) * times);
  for (std::size_t i = 0; i < times; ++i) all += (i > 0 ? separator : std::string()) + text;
  return all;
}

std::string little_endian(std::uint32_t value) {
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) bytes += char(value >> shift & 0xff);
  return bytes;
}

std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

const std::vector<std::string>& seeds_of(const Target& target) {
  static std::map<std::string, std::vector<std::string>> kept;
  std::vector<std::string>& seeds = kept[target.format + target.extension];
  if (!seeds.empty()) return seeds;
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(tests::in_checkout("tests/fuzz/corpus") / target.format))
    if (entry.path().extension() == target.extension) paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  for (const fs::path& path : paths) {
    std::ifstream in(path, std::ios::binary);
    const std::string all((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    const std::string model = all.substr(0, all.find("\n--side-file--\n"));
    seeds.push_back(target.seal ? target.seal(model) : model);
  }
  return seeds;
}

namespace {

std::string sealed(const Target& target, std::string text) {
  return target.seal ? target.seal(std::move(text)) : text;
}

/// A number that readers are likely to stumble over, of either byte order.
std::string extreme_word(std::mt19937& random) {
  constexpr std::uint32_t kWords[] = {0,          1,          2,          9,          11,         12,
                                      24,         40,         100,        255,        0x10000000, 0x3fffffff,
                                      0x7149f2ca, 0x7f7fffff, 0x7f800000, 0x7fc00000, 0x7fffffff, 0x80000000,
                                      0x80000001, 0xff800000, 0xffffffff};
  std::string word = little_endian(random() % 4 ? kWords[random() % std::size(kWords)] : std::uint32_t(random()));
  if (random() % 2) std::reverse(word.begin(), word.end());
  return word;
}

/// Replaces the number or name around `at`.
void change_token(std::string& text, std::size_t at, std::mt19937& random) {
  constexpr std::string_view kTokens =
      "nan inf -1 0 1 1e9 1e39 1e308 1e400 -1e-400 12 42 1000 2147483647 4294967295 4294967296 18446744073709551615 "
      "9223372036854775807  \n < /> \" { ] , : END END: PRIM CNTB CNTE HEAD OBST COLR";
  const auto in_token = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '.'; };
  std::size_t begin = at, end = at;
  while (begin > 0 && in_token(text[begin - 1])) --begin;
  while (end < text.size() && in_token(text[end])) ++end;
  const std::size_t token = kTokens.find(' ', random() % kTokens.rfind(' ')) + 1;
  text.replace(begin, end - begin, kTokens.substr(token, kTokens.find(' ', token) - token));
}

void change(std::string& text, std::size_t at, std::mt19937& random) {
  const std::size_t longest = random() % 4 ? 16 : 200, length = random() % longest;
  switch (random() % 8) {
    case 0:
      text[at] = char(text[at] ^ (1 << random() % 8));
      break;
    case 1:
      text[at] = char(random());
      break;
    case 2:
      text.replace(at / 4 * 4, 4, extreme_word(random));
      break;
    case 3:
      text.replace(at, 4, extreme_word(random));
      break;
    case 4:
      change_token(text, at, random);
      break;
    case 5:
      text.insert(at, text.substr(random() % text.size(), length));
      break;
    case 6:
      text.erase(at, length);
      break;
    default:
      if (random() % 8 == 0) text.resize(at);
      break;
  }
}

}  // namespace

std::string mutated(std::string text, std::mt19937& random) {
  // Half of the cases leave a first part alone: a change of a header often hides all that follows.
  const std::size_t first = random() % 2 ? random() % text.size() : 0;
  const auto most = 1 + random() % 8;
  for (auto times = 1 + random() % most; times > 0 && text.size() > first; --times)
    change(text, first + random() % (text.size() - first), random);
  return text;
}

Case truncated(const Target& target, const std::string& seed, std::size_t length) {
  Case made = one_file(target.model(), sealed(target, seed.substr(0, length)));
  if (!target.needs) return made;
  const Needs needs = target.needs(seed);
  if (length < needs.strict) made.strict = Expect::kFailure;
  if (length < needs.lenient) made.lenient = Expect::kFailure;
  return made;
}

Attack truncation(const Target& target) {
  struct Cut {
    std::size_t seed, length;
  };
  std::vector<Cut> cuts;
  const std::vector<std::string>& seeds = seeds_of(target);
  for (std::size_t s = 0; s < seeds.size(); ++s) {
    const std::size_t size = seeds[s].size(), step = std::max<std::size_t>(size / 100, 1);
    for (std::size_t length = 0; length < size; length += length < 100 ? 1 : step) cuts.push_back({s, length});
  }
  return {"truncation", cuts.size(),
          [target, cuts](std::size_t k) { return truncated(target, seeds_of(target)[cuts[k].seed], cuts[k].length); }};
}

Attack mutation(const Target& target, std::vector<std::string> seeds) {
  return {"mutation", kAnyNumber, [target, seeds = std::move(seeds)](std::size_t k) {
            std::mt19937 random(unsigned(k) + 1);
            const std::vector<std::string>& all = seeds.empty() ? seeds_of(target) : seeds;
            return one_file(target.model(), sealed(target, mutated(all[random() % all.size()], random)));
          }};
}

Attack path_traversal(const std::string& extension, const std::string& secret,
                      std::function<Case(const std::string&)> names) {
  const std::string file = "secret" + extension, outside(kOutside);
  const std::vector<std::string> paths = {"../" + file,    outside + "/" + file, "link" + extension,
                                          "links/" + file, "none/../../" + file, "%2e%2e/" + file,
                                          "..%2f" + file,  "%2E%2E%2F" + file,   "file://" + outside + "/" + file,
                                          "..\\" + file,   "&#46;&#46;/" + file};
  return {"path_traversal", paths.size(), [=](std::size_t k) {
            Case made = names(paths[k]);
            made.files.push_back({"../" + file, secret});
            made.files.push_back({"link" + extension, {}, "../" + file});
            made.files.push_back({"links", {}, ".."});
            return made;
          }};
}

Attack noise(const Target& target) {
  return {"noise", kAnyNumber, [target](std::size_t k) {
            std::mt19937 random(unsigned(k) + 1);
            std::string text;
            if (k % 2) {
              const auto& seeds = seeds_of(target);
              const std::string& seed = seeds[random() % seeds.size()];
              text = seed.substr(0, random() % std::min<std::size_t>(seed.size(), 64));
            }
            for (std::size_t n = 1 + random() % 3000; n > 0; --n) text += char(random() & 0xff);
            Case made = one_file(target.model(), text);
            if (k % 2 == 0) made.strict = made.lenient = target.noise;
            return made;
          }};
}

std::vector<Attack> attacks_on(const Target& target) {
  std::vector<Attack> all = {truncation(target), mutation(target), noise(target)};
  all.insert(all.end(), target.attacks.begin(), target.attacks.end());
  return all;
}

}  // namespace sightline::hostile
