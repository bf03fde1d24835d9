/// docs/telemetry-icd.md says what the packet table says. RELNAV_UPDATE_ICD=1 in the environment rewrites its tables.
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include "tests/unit/telemetry/icd_text.hpp"

#include <CppUTest/TestHarness.h>

namespace {

constexpr const char* begin_marker = "<!-- tables: made from fsw/telemetry, begin -->\n";
constexpr const char* end_marker = "<!-- tables: end -->\n";

std::string document_path() { return RELNAV_SOURCE_DIR "/docs/telemetry-icd.md"; }

}  // namespace

TEST_GROUP(TelemetryIcd){};

TEST(TelemetryIcd, DocumentAgreesWithTheTable) {
  std::ifstream file(document_path());
  CHECK_TRUE(file.is_open());
  std::stringstream content;
  content << file.rdbuf();
  const std::string text = content.str();
  const std::size_t begin_at = text.find(begin_marker);
  const std::size_t end_at = text.find(end_marker);
  CHECK_TRUE(begin_at != std::string::npos);
  CHECK_TRUE(end_at != std::string::npos);
  const std::size_t start = begin_at + std::string(begin_marker).size();
  std::string expected = "\n";
  expected += icd_text::tables();
  expected += "\n";
  if (std::getenv("RELNAV_UPDATE_ICD") != nullptr) {
    std::ofstream(document_path()) << text.substr(0, start) << expected << text.substr(end_at);
    return;
  }
  STRCMP_EQUAL(expected.c_str(), text.substr(start, end_at - start).c_str());
}
