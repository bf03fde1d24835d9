/// docs/telemetry-icd.md says what the packet table says. RELNAV_UPDATE_ICD=1 in the environment rewrites its tables.
#include "tests/support/generated_document.hpp"
#include "tests/unit/telemetry/icd_text.hpp"

#include <CppUTest/TestHarness.h>

TEST_GROUP(TelemetryIcd){};

TEST(TelemetryIcd, DocumentAgreesWithTheTable) {
  relnav::test::check_generated("docs/telemetry-icd.md", "<!-- tables: made from fsw/telemetry, begin -->\n",
                                "<!-- tables: end -->\n", "\n" + icd_text::tables() + "\n", "RELNAV_UPDATE_ICD");
}
