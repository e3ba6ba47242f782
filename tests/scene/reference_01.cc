// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// The reference of all entries: common ones once, each type under its own heading.

#include <dovetail/scene/catalogue.h>
#include <dovetail/scene/scene_text.h>

#include <iostream>

using namespace dovetail;

namespace {

class Tie
{
public:
  explicit Tie(const Section &section)
  {
    section.require_boundary("Source", "Boundary of the source side [-]");
  }
  virtual ~Tie() = default;
};

class Nitsche : public Tie
{
public:
  explicit Nitsche(const Section &section) : Tie(section)
  {
    section.read<double>("Theta", 1, "1 symmetric | 0 nonsymmetric [-]", Patterns::Double(-1, 1));
    section.require_expression("Value", {1}, "Penalty [Pa/m]", {"T"});
  }
};

class Pointwise : public Tie
{
public:
  using Tie::Tie;
};

[[maybe_unused]] const bool registered =
    Catalogue<Tie>::add<Nitsche>("Nitsche", "Weighted penalty and consistency terms.") &&
    Catalogue<Tie>::add<Pointwise>("pointwise", "Constraints at the support points.");

void read(const Section &scene)
{
  scene.dimension();
  for (const std::string &name : scene.announce("Interfaces", "Interface", "Names of the interfaces [-]")) {
    const Section section = scene.subsection("Interface " + name);
    section.require_boundary("Source", "Boundary of the source side [-]");
    Catalogue<Tie>::create(section, "none", "The tie [-]");
    section.read<std::string>("Toggle", "", "Name of a toggle [-]");
  }
  const Section steps = scene.subsection("Steps");
  steps.read<unsigned int>("Number of steps", 1, "Number of steps [-]");
  steps.read<unsigned int>("Repeat", 1, "Number of repetitions [-]", Patterns::Integer(1));
  steps.read<double>("End time", 1, "End time [s]", Patterns::Double(1e-300));
  steps.read<bool>("Adaptive", true, "Halve a step that fails [-]");
  steps.read<std::vector<unsigned int>>("Levels", {0, 1}, "Levels of refinement [-]");
  steps.read<std::vector<double>>("Times", {}, "Times [s]", Patterns::List(Patterns::Double(0)));
  steps.read<std::vector<std::string>>("Fields", {}, "Names of fields [-]");
  steps.choose("Kind", {"static", "transient"}, 0, "Kind [-]");
  steps.read_point("Point", {}, "A point [m]");
  steps.read_expression("Exact", "0; 0; 0", {3}, "A vector [m]");
}

} // namespace

int main()
{
  const auto text = SceneText::for_documentation();
  read(SceneText::root(text));
  text->check_all_read();
  text->print_reference(std::cout);
}
