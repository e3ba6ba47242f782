// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What the user is told about a wrong material.

#include "law_check.h"

void expect_error(const std::string &solid, const std::string &heat)
{
  try {
    make_material<2>(solid, heat);
    std::cout << "NO ERROR for " << solid << " / " << heat << std::endl;
  } catch (const UserError &error) {
    std::cout << error.what() << std::endl;
  }
}

int main()
{
  const std::string linear = "set Type = linear elastic\n";
  const std::string fourier = "set Type = Fourier\nset Conductivity = ";
  const std::string complete = linear + "set Young modulus = 2\nset Poisson ratio = 0.3\n";
  expect_error("", "");
  expect_error(linear, "");
  expect_error(linear + "set Young modulus = 2", "");
  expect_error(linear + "set Bulk modulus = 2", "");
  expect_error(linear + "set Young modulus = 2\nset Shear modulus = 1", "");
  expect_error(complete + "set Bulk modulus = 2", "");
  expect_error(linear + "set Young modulus = -2\nset Poisson ratio = 0.3", "");
  expect_error(linear + "set Young modulus = 2\nset Poisson ratio = 0.5", "");
  expect_error(linear + "set Young modulus = 2\nset Poisson ratio = -1", "");
  expect_error(linear + "set Shear modulus = 0\nset Bulk modulus = 2", "");
  expect_error(linear + "set Shear modulus = 1\nset Bulk modulus = -2", "");
  expect_error(complete + "set Density = -1", "");
  expect_error(complete + "set Formulation = hybrid", "");
  expect_error(complete + "set Expansion coefficient = 1e-5", "");
  expect_error("set Type = neo-Hokean", "");
  expect_error("", "set Type = Fourier");
  expect_error("", fourier + "0");
  expect_error("", fourier + "1; -1");
  expect_error("", fourier + "1; 2; 2; 1");
  expect_error("", fourier + "1; 2; 3");
  expect_error("", fourier + "1 + temperature");
  expect_error("", fourier + "1\nset Heat capacity = -3");
}
