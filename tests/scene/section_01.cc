// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// A scene is read; what was used is itself a scene that reads the same, and so does the same scene in JSON.

#include <dovetail/scene/scene_text.h>

#include <fstream>
#include <iostream>
#include <sstream>

using namespace dovetail;

namespace {

const char *const prm = R"(
set Dimension = 2          # a comment
set Domains   = left, \
                right side
subsection Domain left
  set Degree   =   2
  set Shift    = 0.1; -2
  subsection Source
    set displacement = 0; x*t
  end
end
subsection Domain  right side
  set Boundary = left : 0, 2
  set Arguments = 60, 1 : 0, 0 : true
  set Lengths = 1, 2.5
  set Names = a, b c
  set Levels = 0, 1, 2
  set Follower = true
  set Quadrature = mapped points
end
)";

const char *const json = R"({
  "Dimension": 2,
  "Domains": "left, right side",
  "Domain left": { "Degree": 2, "Shift": "0.1; -2", "Source": { "displacement": "0; x*t" } },
  "Domain right side": { "Boundary": "left : 0, 2", "Arguments": "60, 1 : 0, 0 : true", "Lengths": "1, 2.5",
                         "Names": "a, b c", "Levels": "0, 1, 2", "Follower": true, "Quadrature": "mapped points" }
})";

template <typename T>
std::string joined(const std::vector<T> &values)
{
  std::ostringstream text;
  for (const T &value : values)
    text << '<' << value << '>';
  return text.str();
}

void read_domain(const Section &section, std::ostream &out)
{
  out << section.path() << ": degree " << section.read<unsigned int>("Degree", 1, "Polynomial degree [-]");
  out << ", shift " << section.read_point("Shift", {}, "Shift of the mesh [m]");
  out << ", factor " << section.read<double>("Factor", 0.1, "A factor [-]", Patterns::Double(0));
  out << ", offset " << section.read<int>("Offset", -3, "An offset [-]");
  out << ", follower " << section.read<bool>("Follower", false, "Follows the surface [-]");
  out << ", arguments " << section.read<std::string>("Arguments", "none", "Arguments [-]");
  out << ", lengths " << joined(section.read<std::vector<double>>("Lengths", {}, "Lengths [m]"));
  out << ", names " << joined(section.read<std::vector<std::string>>("Names", {"x"}, "Names [-]"));
  out << ", levels " << joined(section.read<std::vector<unsigned int>>("Levels", {4, 5}, "Levels [-]"));
  out << ", quadrature " << section.choose("Quadrature", {"segments", "mapped points"}, 0, "Quadrature [-]");
  const auto boundary = section.read_boundary("Boundary", "A boundary [-]");
  out << ", boundary '" << boundary.domain << "' " << joined(boundary.ids);
  out << ", degree is set: " << section.is_set("Degree")
      << ", has a source: " << section.has_subsection("Source");
  const Expression source =
      section.subsection("Source").read_expression("displacement", "1; 2", {2}, "Body force [N/m^3]");
  out << ", source " << source.value(dealii::Point<2>(3, 4), 5., 0) << ' '
      << source.value(dealii::Point<2>(3, 4), 5., 1) << '\n';
}

std::string read(const std::shared_ptr<SceneText> &text)
{
  std::ostringstream out;
  const Section scene = SceneText::root(text);
  out << "dimension " << scene.dimension() << '\n';
  for (const std::string &name : scene.announce("Domains", "Domain", "Names of the bodies [-]")) {
    read_domain(scene.subsection("Domain " + name), out);
    scene.subsection("Domain " + name)
        .read<unsigned int>("Degree", 1, "Polynomial degree [-]"); // twice is fine
  }
  text->check_all_read();
  return out.str();
}

std::string used(const SceneText &text)
{
  std::ostringstream out;
  text.print_used(out);
  return out.str();
}

} // namespace

int main()
{
  const auto from_prm = SceneText::from_prm(prm);
  const std::string values = read(from_prm);
  std::cout << values << "\n--- used.prm\n" << used(*from_prm) << "---\n";

  const auto from_used = SceneText::from_prm(used(*from_prm));
  read(from_used);
  std::cout << "used.prm gives the same used.prm: " << (used(*from_used) == used(*from_prm)) << '\n';

  std::ofstream("section_01.json") << json;
  const auto from_json = SceneText::from_file("section_01.json", {});
  std::cout << "JSON reads the same: " << (read(from_json) == values) << ", used "
            << (used(*from_json) == used(*from_prm)) << '\n';

  std::ofstream("section_01_base.prm") << prm;
  std::ofstream("section_01.prm")
      << "include section_01_base.prm\nsubsection Domain left\n  set Degree = 3\nend\n";
  const auto overridden = SceneText::from_file(
      "section_01.prm",
      {"Domain right side/Degree = 4", "Domain left/Source/displacement=7; 8", "Domain left/Offset=1"});
  std::cout << "--- with include and overrides\n" << read(overridden);
}
