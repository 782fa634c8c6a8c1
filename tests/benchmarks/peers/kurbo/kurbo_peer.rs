// kurbo as a peer of peers.cpp: inv_arclen of the segment in which a distance lies.
use kurbo::{CubicBez, ParamCurve, ParamCurveArclen, Point};
use std::time::Instant;

struct Curve {
    seconds: f64,
    accuracy: f64,
    segments: Vec<CubicBez>,
    distances: Vec<f64>,
}

fn read_curve(file: &str) -> Option<Curve> {
    let text = std::fs::read_to_string(file).ok()?;
    let mut numbers = text.split_whitespace().filter_map(|word| word.parse::<f64>().ok());
    let seconds = numbers.next()?;
    let accuracy = numbers.next()?;
    let mut segments = Vec::new();
    for _ in 0..numbers.next()? as usize {
        let mut point = || Some(Point::new(numbers.next()?, numbers.next()?));
        segments.push(CubicBez::new(point()?, point()?, point()?, point()?));
    }
    let count = numbers.next()? as usize;
    let distances: Vec<f64> = numbers.take(count).collect();
    if distances.len() != count || count == 0 {
        return None;
    }
    Some(Curve { seconds, accuracy, segments, distances })
}

fn solve(curve: &Curve, points: &mut Vec<Point>) {
    points.clear();
    let mut segment = 0;
    let mut begin = 0.0; // of the segment
    let mut length = curve.segments[0].arclen(curve.accuracy);
    for &distance in &curve.distances {
        while distance > begin + length && segment + 1 < curve.segments.len() {
            begin += length;
            segment += 1;
            length = curve.segments[segment].arclen(curve.accuracy);
        }
        let cubic = &curve.segments[segment];
        points.push(cubic.eval(cubic.inv_arclen((distance - begin).min(length), curve.accuracy)));
    }
}

fn main() {
    let file = std::env::args().nth(1).unwrap_or_default();
    let Some(curve) = read_curve(&file) else {
        eprintln!("kurbo_peer: error: no curve; name a file that peers.cpp writes");
        std::process::exit(1);
    };
    let mut points = Vec::with_capacity(curve.distances.len());
    let mut least = f64::INFINITY;
    let begin = Instant::now();
    while least == f64::INFINITY || begin.elapsed().as_secs_f64() < curve.seconds {
        let start = Instant::now();
        solve(&curve, &mut points);
        least = least.min(start.elapsed().as_secs_f64());
    }
    println!("{least}");
    for point in &points {
        println!("{} {}", point.x, point.y);
    }
}
