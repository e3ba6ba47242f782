// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// More unknowns than can be numbered are refused, with a message of its own: those of one domain before its
// mesh has any, and those of all domains together. Where deal.II has 64-bit indices, what is refused is the
// memory of the domain, and nothing of the sum.
//
// ranks: 1, 2

#include "../system/scene_model.h"

#include <dovetail/domain/mesh_size.h>

using namespace test;

namespace {

/// Whether @p action is refused with a message in which @p words occur.
bool is_refused(const std::function<void()> &action, const std::string &words)
{
  try {
    action();
  } catch (const UserError &error) {
    return std::string(error.what()).find(words) != std::string::npos;
  }
  return false;
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const bool is_long = sizeof(dealii::types::global_dof_index) > sizeof(int);
  const Section section = SceneText::root(SceneText::from_prm(""));
  const auto of_one = [&]() { check_unknowns<3>(section, 1e9, 2, 3, MPI_COMM_WORLD); };
  report("one domain", is_refused(of_one, is_long ? "GiB of memory" : "can number"));
  report("just too many in all", is_long || is_refused([]() { check_total(2147483648.); }, "can number"));
  report("as many as there are numbers", !is_refused([]() { check_total(2147483647.); }, "can number"));
}
