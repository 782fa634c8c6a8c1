// Open CASCADE as a peer of peers.cpp: GCPnts_AbscissaPoint, from the point of one frame to that of the next.
#include <GCPnts_AbscissaPoint.hxx>
#include <GeomAdaptor_Curve.hxx>
#include <Geom_BezierCurve.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <limits>
#include <vector>

namespace {

struct Curve {
  double seconds = 0;
  double accuracy = 0;
  std::vector<GeomAdaptor_Curve> segments;
  std::vector<double> distances;
};

Curve read_curve(const char* file) {
  std::ifstream in(file);
  Curve curve;
  std::size_t count = 0;
  in >> curve.seconds >> curve.accuracy >> count;
  for (std::size_t i = 0; i < count; ++i) {
    TColgp_Array1OfPnt points(1, 4);
    for (int k = 1; k <= 4; ++k) {
      double x = 0;
      double y = 0;
      in >> x >> y;
      points(k) = gp_Pnt(x, y, 0);
    }
    curve.segments.emplace_back(new Geom_BezierCurve(points));
  }
  in >> count;
  curve.distances.resize(count);
  for (double& distance : curve.distances) in >> distance;
  if (!in) curve.distances.clear();
  return curve;
}

void solve(const Curve& curve, std::vector<gp_Pnt>& points) {
  std::size_t segment = 0;
  double begin = 0;  // of the segment
  double length = GCPnts_AbscissaPoint::Length(curve.segments[0], curve.accuracy);
  double last_distance = 0;
  double u = 0;
  for (std::size_t i = 0; i < curve.distances.size(); ++i) {
    const double distance = curve.distances[i];
    while (distance > begin + length && segment + 1 < curve.segments.size()) {
      begin += length;
      length = GCPnts_AbscissaPoint::Length(curve.segments[++segment], curve.accuracy);
      last_distance = begin;
      u = 0;
    }
    const GeomAdaptor_Curve& adaptor = curve.segments[segment];
    u = GCPnts_AbscissaPoint(curve.accuracy, adaptor, distance - last_distance, u).Parameter();
    last_distance = distance;
    points[i] = adaptor.Value(u);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const Curve curve = argc == 2 ? read_curve(argv[1]) : Curve{};
  if (curve.distances.empty()) {
    std::fprintf(stderr, "occt_peer: error: no curve; name a file that peers.cpp writes\n");
    return 1;
  }
  using Clock = std::chrono::steady_clock;
  std::vector<gp_Pnt> points(curve.distances.size());
  double least = std::numeric_limits<double>::infinity();
  const auto begin = Clock::now();
  do {
    const auto start = Clock::now();
    solve(curve, points);
    least = std::min(least, std::chrono::duration<double>(Clock::now() - start).count());
  } while (Clock::now() - begin < std::chrono::duration<double>(curve.seconds));
  std::printf("%.9g\n", least);
  for (const gp_Pnt& point : points) std::printf("%.17g %.17g\n", point.X(), point.Y());
}
