// What stands where in the image, against the flight code's camera model.
#include "fsw/base/generator.hpp"
#include "tests/unit/hil_render/scene_case.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using namespace relnav::hil;
using namespace relnav::test;

namespace {

TargetModel lights_at(const std::vector<Vec3>& points_T) {
  TargetModel target;
  for (const Vec3& p_T : points_T) {
    TargetFeature feature;
    feature.id = static_cast<std::uint16_t>(target.features.size());
    feature.p_T = p_T;
    CHECK(target.features.push_back(feature) == Status::ok);
  }
  return target;
}

Vec2 centroid(const Image& image, const Vec2& about, int half) {
  Vec2 sum = Vec2::Zero();
  double weight = 0.0;
  for (int v = static_cast<int>(about.y()) - half; v <= static_cast<int>(about.y()) + half; ++v) {
    for (int u = static_cast<int>(about.x()) - half; u <= static_cast<int>(about.x()) + half; ++u) {
      const double w = level(image, static_cast<std::uint32_t>(u), static_cast<std::uint32_t>(v));
      sum += w * Vec2(u, v);
      weight += w;
    }
  }
  return sum / weight;
}

Mat3 turned(double about_x, double about_y) {
  Mat3 R_x = Mat3::Identity();
  R_x(1, 1) = R_x(2, 2) = std::cos(about_x);
  R_x(2, 1) = std::sin(about_x);
  R_x(1, 2) = -R_x(2, 1);
  Mat3 R_y = Mat3::Identity();
  R_y(0, 0) = R_y(2, 2) = std::cos(about_y);
  R_y(0, 2) = std::sin(about_y);
  R_y(2, 0) = -R_y(0, 2);
  return R_y * R_x;
}

}  // namespace

TEST_GROUP(RenderProjection) {
  CameraModel camera = camera_of(640, 480, 700.0, true);

  /// Worst distance of a light's centroid from where the camera model says, over the image at one distance.
  double worst_light_px(double distance) {
    RenderSettings settings = plain_settings();
    settings.light_radiance = 1.0;
    const double reach = 0.33 * distance;
    std::vector<Vec3> points_T;
    for (int i = 0; i < 5; ++i) {
      for (int j = 0; j < 5; ++j) {
        points_T.emplace_back(reach * (i - 2) / 2.0 + 0.013 * j, 0.75 * reach * (j - 2) / 2.0 - 0.007 * i,
                              0.01 * distance * ((i * j) % 3));
      }
    }
    const TargetModel lights = lights_at(points_T);
    MeshBuilder builder;  // out of sight
    add_square(builder, 0.0, 0.0, 3.0 * distance, 0.001, builder.add_material(matt(0.0F)));
    SceneRenderer renderer(settings, camera, &lights, 1, builder.mesh());
    double worst = 0.0;
    int seen = 0;
    Generator generator(3);
    for (int pose = 0; pose < 4; ++pose) {
      SceneState state = ahead(distance);
      state.sunlight = 0.0;
      const double about_x = 0.2 * (generator.uniform() - 0.5);
      const double about_y = 0.2 * (generator.uniform() - 0.5);
      state.R_CT = turned(about_x, about_y);
      const Image image = rendered(renderer, state, 0.5 * quarter_s);
      for (const Vec3& p_T : points_T) {
        Vec2 expected;
        if (camera.project(state.R_CT * p_T + state.t_CT, expected) != Status::ok) continue;
        if (!camera.in_image(expected, 20.0)) continue;
        ++seen;
        worst = std::max(worst, (centroid(image, expected, 14) - expected).norm());
      }
    }
    CHECK(seen > 40);
    return worst;
  }

  /// A luminous square's four edges: in every row or column that one crosses, the sum of levels up to the middle tells where.
  /// Mean and root mean square of the differences, over all edges; px.
  void edge_error(std::uint32_t samples, double& worst_mean, double& rms) {
    RenderSettings settings = plain_settings();
    settings.edge_samples = samples;
    const double half = 0.8;
    SceneRenderer renderer(settings, camera, nullptr, 1, one_square(half, luminous(1.0F)));
    SceneState state = ahead(3.0);
    state.R_CT = turned(0.15, -0.22);
    state.t_CT += Vec3(0.05, -0.03, 0.0);
    const Image image = rendered(renderer, state);
    const double full = level(image, 320, 240);
    worst_mean = 0.0;
    double squares = 0.0;
    int count = 0;
    for (int side = 0; side < 4; ++side) {
      const bool is_upright = side < 2;
      const double sign = side % 2 == 0 ? -1.0 : 1.0;
      double sum = 0.0;
      int rows = 0;
      for (int line = is_upright ? 160 : 240; line < (is_upright ? 320 : 400); ++line) {
        // Where the camera model sees the edge in this row (column): bisection along it.
        double low = -half;
        double high = half;
        Vec2 uv = Vec2::Zero();
        for (int i = 0; i < 60; ++i) {
          const double along = 0.5 * (low + high);
          const Vec3 p_T = is_upright ? Vec3(sign * half, along, 0.0) : Vec3(along, sign * half, 0.0);
          CHECK(camera.project(state.R_CT * p_T + state.t_CT, uv) == Status::ok);
          ((is_upright ? uv.y() : uv.x()) < line ? low : high) = along;
        }
        const double expected = is_upright ? uv.x() : uv.y();
        const int near = static_cast<int>(expected);
        double lit = 0.0;  // pixels between a place inside and one outside
        for (int k = near - 8; k <= near + 8; ++k) {
          const auto u = static_cast<std::uint32_t>(is_upright ? k : line);
          const auto v = static_cast<std::uint32_t>(is_upright ? line : k);
          lit += level(image, u, v) / full;
        }
        const double edge = sign > 0.0 ? near - 8.5 + lit : near + 8.5 - lit;
        sum += edge - expected;
        squares += (edge - expected) * (edge - expected);
        ++rows;
        ++count;
      }
      worst_mean = std::max(worst_mean, std::fabs(sum / rows));
    }
    rms = std::sqrt(squares / count);
  }
};

TEST(RenderProjection, LightsHaveTheirCentroidWhereTheCameraModelSaysSo) {
  for (const double distance : {2.5, 4.0, 8.0, 15.0, 40.0}) {
    const double worst = worst_light_px(distance);
    printf("lights at %.1f m: worst centroid %.4f px\n", distance, worst);
    CHECK(worst < 0.02);
  }
}

TEST(RenderProjection, EdgesOfAMeshLieWhereTheCameraModelSaysSo) {
  double worst_mean = 1.0;
  double rms = 1.0;
  edge_error(4, worst_mean, rms);
  printf("edges, 4 rays: mean of a side at most %.4f px, rms of a row %.4f px\n", worst_mean, rms);
  CHECK(worst_mean < 0.02);
  CHECK(rms < 0.08);
  edge_error(8, worst_mean, rms);
  printf("edges, 8 rays: mean of a side at most %.4f px, rms of a row %.4f px\n", worst_mean, rms);
  CHECK(worst_mean < 0.02);
  CHECK(rms < 0.06);
  edge_error(64, worst_mean, rms);
  printf("edges, 64 rays: mean of a side at most %.4f px, rms of a row %.4f px\n", worst_mean, rms);
  CHECK(worst_mean < 0.005);
  CHECK(rms < 0.02);
}

TEST(RenderProjection, ALightBehindTheMeshIsNotSeen) {
  const TargetModel lights = lights_at({Vec3(0.0, 0.0, 0.5), Vec3(1.0, 0.0, 0.5)});
  SceneRenderer renderer(plain_settings(), camera, &lights, 1, one_square(0.4, matt(0.0F)));
  SceneState state = ahead(4.0);
  state.sunlight = 0.0;
  const Image image = rendered(renderer, state);
  Vec2 hidden;
  Vec2 seen;
  CHECK(camera.project(Vec3(0.0, 0.0, 4.5), hidden) == Status::ok);
  CHECK(camera.project(Vec3(1.0, 0.0, 4.5), seen) == Status::ok);
  const auto at = [&](const Vec2& uv) {
    return level(image, static_cast<std::uint32_t>(std::lround(uv.x())),
                 static_cast<std::uint32_t>(std::lround(uv.y())));
  };
  DOUBLES_EQUAL(0.0, at(hidden), 0.5);
  CHECK(at(seen) > 30'000.0);
}

TEST(RenderProjection, ALightWithANormalIsDarkFromBehind) {
  TargetModel lights = lights_at({Vec3(-0.5, 0.0, 0.0), Vec3(0.5, 0.0, 0.0)});
  lights.features[0].normal_T = Vec3(0.0, 0.0, -1.0);
  lights.features[1].normal_T = Vec3(0.0, 0.0, 1.0);
  MeshBuilder builder;
  add_square(builder, 0.0, 0.0, 3.0, 0.001, builder.add_material(matt(0.0F)));
  SceneRenderer renderer(plain_settings(), camera, &lights, 1, builder.mesh());
  SceneState state = ahead(4.0);
  state.sunlight = 0.0;
  const Image image = rendered(renderer, state);
  Vec2 toward;
  Vec2 away;
  CHECK(camera.project(Vec3(-0.5, 0.0, 4.0), toward) == Status::ok);
  CHECK(camera.project(Vec3(0.5, 0.0, 4.0), away) == Status::ok);
  CHECK(level(image, static_cast<std::uint32_t>(toward.x()), static_cast<std::uint32_t>(toward.y())) > 30'000.0);
  DOUBLES_EQUAL(0.0, level(image, static_cast<std::uint32_t>(away.x()), static_cast<std::uint32_t>(away.y())), 0.5);
}

TEST(RenderProjection, ACameraIsInsideWhereTheMeshIsAllAround) {
  const SceneRenderer renderer(plain_settings(), camera_of(64, 48, 60.0, false), nullptr, 1);
  SceneState state;
  const auto at = [&](double x, double y, double z) {
    state.t_CT = -Vec3(x, y, z);  // axes of T and C alike
    return renderer.is_inside(state);
  };
  CHECK_TRUE(at(0.5, 0.4, 0.5));    // in the bus
  CHECK_FALSE(at(0.0, 0.0, -3.0));  // ahead of the docking face
  CHECK_FALSE(at(1.2, 1.2, -0.5));  // within reach of the wings, outside
  CHECK_FALSE(at(40.0, 0.0, 0.0));
}
