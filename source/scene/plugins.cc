// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/scene/catalogue.h>
#include <dovetail/scene/input_file.h>
#include <dovetail/scene/plugins.h>

#include <dlfcn.h>
#include <filesystem>

namespace dovetail {

std::vector<std::string> &names_registered_twice()
{
  static std::vector<std::string> names;
  return names;
}

void load_plugins(const Section &scene)
{
  for (const std::string &name :
       scene.read<std::vector<std::string>>("Plugins", {},
                                            "Shared libraries with your own laws, conditions, ties, solvers "
                                            "or quantities, see doc/how_to/write_a_plugin.md [-]",
                                            Patterns::List(Patterns::Anything()))) {
    const std::string path = std::filesystem::absolute(name).string(); // else the linker looks elsewhere
    const std::string obstacle = obstacle_to_reading(path);
    scene.check(obstacle.empty(), "Plugins", "names '" + name + "', which " + obstacle);
    const std::size_t n_twice = names_registered_twice().size();
    if (dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL) == nullptr) {
      const char *const reason = dlerror();
      scene.fail("Plugins", "names '" + name + "', which cannot be loaded: " +
                                (reason == nullptr ? "no reason is given" : std::string(reason)) +
                                ". Compile it against this version of the program.");
    }
    scene.check(names_registered_twice().size() == n_twice, "Plugins",
                "names '" + name + "', which brings the Type '" +
                    (n_twice < names_registered_twice().size() ? names_registered_twice().back() : "") +
                    "', but there is one already. Give it another name.");
  }
}

} // namespace dovetail
