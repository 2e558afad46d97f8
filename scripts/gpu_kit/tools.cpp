// All tools of the kit in one program, which is the tool by whose name it is called. Each tool's main is compiled under
// the name declared here (CMakeLists.txt).
#include <cstdio>
#include <filesystem>
#include <string>

int sightline_bench_main(int argc, char** argv);
int sightline_generate_main(int argc, char** argv);
int sightline_info_main(int argc, char** argv);
int sightline_render_main(int argc, char** argv);
int sightline_replay_main(int argc, char** argv);
int sightline_stability_main(int argc, char** argv);

namespace {

struct Tool {
  const char* name;
  int (*main)(int argc, char** argv);
};

constexpr Tool kTools[] = {{"sightline-bench", sightline_bench_main},
                           {"sightline-generate", sightline_generate_main},
                           {"sightline-info", sightline_info_main},
                           {"sightline-render", sightline_render_main},
                           {"sightline-replay", sightline_replay_main},
                           {"sightline-stability", sightline_stability_main}};

}  // namespace

int main(int argc, char** argv) {
  const std::string name = argc > 0 ? std::filesystem::path(argv[0]).filename().string() : std::string();
  for (const Tool& tool : kTools)
    if (name == tool.name) return tool.main(argc, argv);
  std::fprintf(stderr, "%s: call this program by one of these names:", name.c_str());
  for (const Tool& tool : kTools) std::fprintf(stderr, " %s", tool.name);
  std::fprintf(stderr, "\n");
  return 2;
}
