#pragma once
/// A contract is a set of function templates, one a clause, over a harness that knows how to play the outside world for one
/// implementation. RELNAV_CLAUSE(group, clause) makes a test of it; `Harness harness` is a member of the group.
#include <CppUTest/TestHarness.h>

#define RELNAV_CLAUSE(group, contract, clause) \
  TEST(group, clause) { contract::clause(harness); }
