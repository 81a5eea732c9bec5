//! The plans of `synthetic-otb`: what each sequence shows.

use super::actor::Kind;
use super::ground::Ground;
use super::scene::{Actor, ScenePlan};

const A: Actor = Actor::STILL;
const P: ScenePlan = ScenePlan::EMPTY;
/// A walking person of about the size most plans use.
const WALKER: Actor = Actor { kind: Kind::Person, size: (25.0, 74.0), cadence: 0.045, ..A };

/// The sequences, in the order of their names.
#[rustfmt::skip]
pub const PLANS: &[ScenePlan] = &[
    // A fish among fish of its kind.
    ScenePlan {
        name: "Aquarium",
        attributes: &["background-clutter", "deformation", "out-of-plane-rotation", "scale-change"],
        frames: 180, ground: Ground::Water,
        behind: &[
            Actor { kind: Kind::Fish, look: 12, size: (66.0, 32.0), x: &[(0.0, 20.0), (180.0, 320.0)],
                y: &[(0.0, 60.0), (90.0, 80.0), (180.0, 50.0)], cadence: 0.05, ..A },
            Actor { kind: Kind::Fish, look: 8, size: (58.0, 28.0),
                x: &[(0.0, 300.0), (90.0, 60.0), (180.0, 240.0)], y: &[(0.0, 190.0), (180.0, 200.0)],
                cadence: 0.06, ..A },
        ],
        target: Actor { kind: Kind::Fish, look: 8, size: (62.0, 30.0),
            x: &[(0.0, 70.0), (60.0, 190.0), (110.0, 250.0), (150.0, 170.0), (180.0, 90.0)],
            y: &[(0.0, 100.0), (45.0, 140.0), (90.0, 90.0), (130.0, 150.0), (180.0, 120.0)],
            scale: &[(0.0, 1.0), (100.0, 1.25), (180.0, 0.9)],
            turn: &[(0.0, 0.0), (40.0, 14.0), (90.0, -16.0), (135.0, 12.0), (180.0, 0.0)], cadence: 0.05,
            ..A },
        front: &[
            Actor { kind: Kind::Fish, look: 8, size: (62.0, 30.0),
                x: &[(0.0, 330.0), (70.0, 240.0), (120.0, 110.0), (180.0, 20.0)],
                y: &[(0.0, 150.0), (70.0, 130.0), (120.0, 120.0), (180.0, 170.0)], cadence: 0.05, ..A },
        ],
        ..P
    },
    // A motorcycle that bushes hide in part.
    ScenePlan {
        name: "Bushes",
        attributes: &["background-clutter", "in-plane-rotation", "occlusion", "out-of-plane-rotation"],
        size: (360, 240), frames: 200, ground: Ground::Meadow,
        target: Actor { kind: Kind::Rider, look: 4, size: (66.0, 52.0), x: &[(0.0, 60.0), (200.0, 780.0)],
            y: &[(0.0, 150.0), (40.0, 140.0), (70.0, 156.0), (110.0, 138.0), (150.0, 158.0),
                (200.0, 146.0)],
            turn: &[(0.0, 0.0), (40.0, -12.0), (70.0, 12.0), (110.0, -16.0), (150.0, 14.0), (200.0, 0.0)],
            ..A },
        front: &[
            Actor { kind: Kind::Bush, look: 3, size: (50.0, 44.0), x: &[(0.0, 230.0)], y: &[(0.0, 172.0)],
                ..A },
            Actor { kind: Kind::Bush, look: 5, size: (84.0, 74.0), x: &[(0.0, 430.0)], y: &[(0.0, 160.0)],
                ..A },
            Actor { kind: Kind::Post, look: 7, size: (18.0, 200.0), x: &[(0.0, 560.0)], y: &[(0.0, 90.0)],
                ..A },
            Actor { kind: Kind::Bush, look: 9, size: (60.0, 54.0), x: &[(0.0, 650.0)], y: &[(0.0, 176.0)],
                ..A },
        ],
        camera_x: &[(0.0, 0.0), (30.0, 20.0), (170.0, 520.0), (200.0, 560.0)],
        shake: 1.5,
        ..P
    },
    // A car seen from behind that drives off and is caught up with.
    ScenePlan {
        name: "CarAway",
        attributes: &["illumination-change", "occlusion", "scale-change"],
        frames: 220, ground: Ground::Street,
        behind: &[
            Actor { kind: Kind::Rear, look: 9, size: (60.0, 50.0), x: &[(0.0, 20.0), (220.0, 70.0)],
                y: &[(0.0, 190.0), (220.0, 168.0)], scale: &[(0.0, 1.0), (220.0, 0.6)], ..A },
        ],
        target: Actor { kind: Kind::Rear, look: 2, size: (62.0, 52.0),
            x: &[(0.0, 150.0), (60.0, 180.0), (120.0, 200.0), (170.0, 170.0), (220.0, 140.0)],
            y: &[(0.0, 185.0), (110.0, 158.0), (220.0, 190.0)],
            scale: &[(0.0, 1.0), (110.0, 0.78), (140.0, 0.8), (220.0, 1.1)], ..A },
        front: &[
            Actor { kind: Kind::Hoarding, look: 4, size: (90.0, 70.0),
                x: &[(0.0, 420.0), (110.0, 390.0), (138.0, 190.0), (160.0, -20.0), (180.0, -120.0)],
                y: &[(0.0, 160.0)], ..A },
        ],
        light: &[(0.0, 1.0), (60.0, 1.0), (80.0, 0.55), (130.0, 0.6), (160.0, 1.1), (220.0, 1.0)],
        shake: 2.0,
        ..P
    },
    // Two alike who walk together, seen by a camera that is thrown about.
    ScenePlan {
        name: "Couple",
        attributes: &["background-clutter", "deformation", "fast-motion", "scale-change"],
        frames: 150, ground: Ground::Street,
        behind: &[
            Actor { look: 6, size: (22.0, 64.0), x: &[(0.0, 178.0), (150.0, 330.0)], y: &[(0.0, 150.0)],
                scale: &[(0.0, 1.0), (150.0, 1.25)], pose: &[(0.0, 0.4)], ..WALKER },
        ],
        target: Actor { look: 6, size: (22.0, 64.0), x: &[(0.0, 146.0), (150.0, 296.0)], y: &[(0.0, 152.0)],
            scale: &[(0.0, 1.0), (150.0, 1.25)], ..WALKER },
        front: &[
            Actor { kind: Kind::Post, look: 12, size: (16.0, 220.0), x: &[(0.0, 232.0)], y: &[(0.0, 110.0)],
                ..A },
        ],
        camera_x: &[(0.0, 40.0), (38.0, 60.0), (42.0, 18.0), (70.0, 60.0), (74.0, 120.0), (78.0, 90.0),
                (110.0, 130.0), (114.0, 170.0), (150.0, 150.0)],
        camera_y: &[(0.0, 0.0), (38.0, 4.0), (43.0, 26.0), (70.0, 0.0), (75.0, -20.0), (110.0, 0.0),
                (115.0, 18.0), (150.0, 0.0)],
        shake: 2.0, exposure: 0.5,
        ..P
    },
    // A crossing of people, one of them dressed like the target.
    ScenePlan {
        name: "Crowd",
        attributes: &["background-clutter", "deformation", "occlusion"],
        frames: 210, ground: Ground::Meadow,
        behind: &[
            Actor { look: 21, size: (24.0, 70.0), x: &[(0.0, 250.0), (100.0, 130.0), (210.0, 40.0)],
                y: &[(0.0, 128.0)], ..WALKER },
            Actor { look: 14, size: (23.0, 68.0), x: &[(0.0, 40.0), (210.0, 270.0)], y: &[(0.0, 130.0)],
                ..WALKER },
        ],
        target: Actor { look: 15,
            x: &[(0.0, 60.0), (90.0, 200.0), (120.0, 240.0), (165.0, 170.0), (210.0, 80.0)],
            y: &[(0.0, 142.0), (210.0, 150.0)], ..WALKER },
        front: &[
            Actor { look: 15, x: &[(0.0, 300.0), (60.0, 190.0), (120.0, 90.0), (210.0, -20.0)],
                y: &[(0.0, 147.0)], ..WALKER },
            Actor { look: 23, size: (28.0, 82.0),
                x: &[(0.0, -60.0), (60.0, 20.0), (150.0, 190.0), (210.0, 330.0)], y: &[(0.0, 156.0)],
                ..WALKER },
        ],
        ..P
    },
    // A small face in a room that turns, behind which and before which others pass.
    ScenePlan {
        name: "Girl",
        attributes: &["in-plane-rotation", "occlusion", "out-of-plane-rotation", "scale-change"],
        size: (160, 120), frames: 250, ground: Ground::Room,
        target: Actor { kind: Kind::Face, look: 3, size: (30.0, 38.0),
            x: &[(0.0, 70.0), (40.0, 92.0), (80.0, 60.0), (130.0, 80.0), (165.0, 100.0), (200.0, 64.0),
                (250.0, 84.0)],
            y: &[(0.0, 58.0), (60.0, 50.0), (120.0, 62.0), (180.0, 52.0), (250.0, 60.0)],
            scale: &[(0.0, 1.0), (80.0, 1.3), (150.0, 0.85), (250.0, 1.1)],
            turn: &[(0.0, 0.0), (50.0, 10.0), (100.0, -14.0), (170.0, 12.0), (250.0, 0.0)],
            pose: &[(0.0, 0.0), (30.0, 0.0), (55.0, 1.0), (75.0, -0.9), (100.0, 0.0), (150.0, 0.1),
                (185.0, 0.9), (215.0, 0.0)], ..A },
        front: &[
            Actor { kind: Kind::Face, look: 10, size: (36.0, 46.0),
                x: &[(0.0, 210.0), (110.0, 190.0), (134.0, 84.0), (148.0, 80.0), (172.0, -40.0),
                    (250.0, -60.0)], y: &[(0.0, 62.0), (140.0, 58.0)], pose: &[(0.0, -0.6)], ..A },
        ],
        noise: 9.0,
        ..P
    },
    // A face that jumps up and down before a camera too slow for it.
    ScenePlan {
        name: "Jumping",
        attributes: &["fast-motion", "motion-blur"],
        size: (352, 288), frames: 140, ground: Ground::Bricks,
        target: Actor { kind: Kind::Face, look: 6, size: (36.0, 45.0),
            x: &[(0.0, 160.0), (70.0, 178.0), (140.0, 165.0)],
            y: &[(0.0, 140.0), (20.0, 140.0), (25.0, 96.0), (31.0, 150.0), (36.0, 92.0), (42.0, 150.0),
                (47.0, 70.0), (53.0, 152.0), (70.0, 140.0), (75.0, 84.0), (81.0, 152.0), (85.0, 66.0),
                (90.0, 152.0), (110.0, 140.0), (115.0, 90.0), (121.0, 146.0), (140.0, 140.0)],
            pose: &[(0.0, 0.1)], ..A },
        shake: 3.0, exposure: 0.8,
        ..P
    },
    // A face under lights that go on and off, with a shadow over half of it.
    ScenePlan {
        name: "Lights",
        attributes: &["illumination-change", "in-plane-rotation", "out-of-plane-rotation", "scale-change"],
        frames: 200, ground: Ground::Room,
        target: Actor { kind: Kind::Face, look: 14, size: (60.0, 74.0),
            x: &[(0.0, 130.0), (50.0, 170.0), (100.0, 120.0), (150.0, 190.0), (200.0, 150.0)],
            y: &[(0.0, 112.0), (70.0, 96.0), (140.0, 124.0), (200.0, 110.0)],
            scale: &[(0.0, 1.0), (100.0, 1.2), (200.0, 0.9)],
            turn: &[(0.0, 0.0), (60.0, 16.0), (110.0, -12.0), (160.0, 18.0), (200.0, 0.0)],
            pose: &[(0.0, 0.0), (60.0, 0.0), (90.0, 0.8), (120.0, 0.0), (150.0, -0.9), (180.0, 0.0)], ..A },
        light: &[(0.0, 1.0), (30.0, 1.0), (33.0, 0.35), (52.0, 0.35), (55.0, 1.5), (70.0, 1.0),
                (95.0, 1.0), (98.0, 0.25), (125.0, 0.3), (128.0, 1.3), (160.0, 0.8), (200.0, 1.0)],
        shadow: &[(0.0, -100.0), (60.0, -80.0), (120.0, 180.0), (150.0, 120.0), (200.0, 400.0)],
        shadow_width: 90.0,
        ..P
    },
    // Somebody who walks behind a parked lorry, comes out and goes back.
    ScenePlan {
        name: "Lorry",
        attributes: &["deformation", "occlusion"],
        frames: 240, ground: Ground::Street,
        behind: &[
            Actor { look: 40, size: (22.0, 66.0), x: &[(0.0, 290.0), (240.0, 210.0)], y: &[(0.0, 126.0)],
                ..WALKER },
        ],
        target: Actor { look: 31, x: &[(0.0, 30.0), (110.0, 286.0), (130.0, 290.0), (240.0, 40.0)],
            y: &[(0.0, 136.0)], ..WALKER },
        front: &[
            Actor { kind: Kind::Hoarding, look: 6, size: (76.0, 92.0), x: &[(0.0, 165.0)],
                y: &[(0.0, 142.0)], ..A },
        ],
        ..P
    },
    // A reader whom the magazine covers.
    ScenePlan {
        name: "Magazine",
        attributes: &["occlusion"],
        size: (352, 288), frames: 240, ground: Ground::Room,
        target: Actor { kind: Kind::Face, look: 22, size: (88.0, 110.0),
            x: &[(0.0, 170.0), (90.0, 182.0), (170.0, 160.0), (240.0, 176.0)],
            y: &[(0.0, 140.0), (120.0, 150.0), (240.0, 138.0)], ..A },
        front: &[
            Actor { kind: Kind::Card, look: 5, size: (84.0, 104.0),
                x: &[(0.0, 60.0), (20.0, 60.0), (50.0, 150.0), (70.0, 128.0), (100.0, 240.0),
                    (120.0, 200.0), (150.0, 190.0), (185.0, 180.0), (215.0, 300.0), (240.0, 320.0)],
                y: &[(0.0, 260.0), (20.0, 240.0), (50.0, 200.0), (100.0, 190.0), (130.0, 120.0),
                    (160.0, 206.0), (190.0, 190.0), (215.0, 230.0)],
                turn: &[(0.0, -20.0), (60.0, 6.0), (120.0, 25.0), (180.0, 0.0), (240.0, 30.0)], ..A },
        ],
        ..P
    },
    // Everything at once: distance, a tree, shadow, people.
    ScenePlan {
        name: "Marathon",
        attributes: &["background-clutter", "deformation", "illumination-change", "occlusion", "scale-change"],
        size: (480, 270), frames: 250, ground: Ground::Meadow,
        behind: &[
            Actor { look: 52, size: (25.0, 74.0), x: &[(0.0, 200.0), (250.0, 620.0)], y: &[(0.0, 140.0)],
                cadence: 0.07, ..WALKER },
            Actor { look: 60, size: (25.0, 74.0), x: &[(0.0, 60.0), (250.0, 700.0)], y: &[(0.0, 144.0)],
                cadence: 0.07, ..WALKER },
        ],
        target: Actor { look: 66, size: (28.0, 84.0),
            x: &[(0.0, 110.0), (80.0, 330.0), (140.0, 480.0), (190.0, 660.0), (250.0, 760.0)],
            y: &[(0.0, 160.0), (140.0, 140.0), (250.0, 165.0)],
            scale: &[(0.0, 1.0), (140.0, 0.7), (250.0, 1.15)], cadence: 0.07, ..WALKER },
        front: &[
            Actor { kind: Kind::Post, look: 3, size: (44.0, 240.0), x: &[(0.0, 380.0)], y: &[(0.0, 100.0)],
                ..A },
            Actor { look: 66, size: (28.0, 84.0), x: &[(0.0, 560.0), (120.0, 520.0), (250.0, 420.0)],
                y: &[(0.0, 172.0)], cadence: 0.07, ..WALKER },
        ],
        camera_x: &[(0.0, 0.0), (60.0, 70.0), (200.0, 440.0), (250.0, 520.0)],
        shadow: &[(0.0, 560.0)],
        shadow_width: 70.0, shake: 2.0,
        ..P
    },
    // A pan along a road with lamp posts before the car.
    ScenePlan {
        name: "Pan",
        attributes: &["motion-blur", "occlusion"],
        frames: 150, ground: Ground::Street,
        target: Actor { kind: Kind::Car, look: 3, size: (86.0, 40.0), x: &[(0.0, 90.0), (150.0, 1040.0)],
            y: &[(0.0, 178.0), (60.0, 182.0), (150.0, 176.0)], ..A },
        front: &[
            Actor { kind: Kind::Post, look: 6, size: (12.0, 240.0), x: &[(0.0, 300.0)], y: &[(0.0, 110.0)],
                ..A },
            Actor { kind: Kind::Post, look: 8, size: (16.0, 240.0), x: &[(0.0, 520.0)], y: &[(0.0, 110.0)],
                ..A },
            Actor { kind: Kind::Hoarding, look: 11, size: (100.0, 80.0), x: &[(0.0, 760.0)],
                y: &[(0.0, 186.0)], ..A },
        ],
        camera_x: &[(0.0, 0.0), (20.0, 20.0), (130.0, 800.0), (150.0, 860.0)],
        shake: 1.0, exposure: 0.5,
        ..P
    },
    // A car that drives past parked cars of the same make.
    ScenePlan {
        name: "Parking",
        attributes: &["background-clutter", "fast-motion", "occlusion"],
        size: (352, 240), frames: 160, ground: Ground::Street,
        behind: &[
            Actor { kind: Kind::Car, look: 8, size: (76.0, 36.0), x: &[(0.0, 180.0)], y: &[(0.0, 152.0)],
                ..A },
            Actor { kind: Kind::Car, look: 8, size: (76.0, 36.0), x: &[(0.0, 330.0)], y: &[(0.0, 152.0)],
                ..A },
            Actor { kind: Kind::Car, look: 13, size: (78.0, 36.0), x: &[(0.0, 510.0)], y: &[(0.0, 152.0)],
                ..A },
        ],
        target: Actor { kind: Kind::Car, look: 8, size: (80.0, 38.0),
            x: &[(0.0, 60.0), (60.0, 210.0), (110.0, 500.0), (160.0, 560.0)],
            y: &[(0.0, 176.0), (80.0, 170.0), (160.0, 176.0)], ..A },
        front: &[
            Actor { kind: Kind::Post, look: 6, size: (14.0, 240.0), x: &[(0.0, 270.0)], y: &[(0.0, 110.0)],
                ..A },
            Actor { kind: Kind::Car, look: 5, size: (96.0, 46.0),
                x: &[(0.0, 700.0), (70.0, 540.0), (105.0, 440.0), (160.0, 120.0)], y: &[(0.0, 186.0)], ..A
            },
        ],
        camera_x: &[(0.0, 0.0), (30.0, 0.0), (70.0, 80.0), (120.0, 330.0), (160.0, 360.0)],
        ..P
    },
    // A book that is turned, tilted, brought near, and swapped before another.
    ScenePlan {
        name: "Reader",
        attributes: &["background-clutter", "in-plane-rotation", "scale-change"],
        frames: 190, ground: Ground::Room,
        behind: &[
            Actor { kind: Kind::Card, look: 15, size: (44.0, 58.0), x: &[(0.0, 250.0)], y: &[(0.0, 160.0)],
                ..A },
        ],
        target: Actor { kind: Kind::Card, look: 11, size: (46.0, 60.0),
            x: &[(0.0, 100.0), (50.0, 150.0), (90.0, 120.0), (140.0, 210.0), (190.0, 110.0)],
            y: &[(0.0, 120.0), (60.0, 100.0), (120.0, 140.0), (190.0, 115.0)],
            scale: &[(0.0, 1.0), (70.0, 1.5), (120.0, 0.7), (190.0, 1.0)],
            turn: &[(0.0, 0.0), (40.0, 8.0), (80.0, -30.0), (130.0, 60.0), (160.0, 60.0), (190.0, 0.0)], ..A
        },
        exposure: 0.4,
        ..P
    },
    // Somebody who walks through bands of sun and shadow.
    ScenePlan {
        name: "Shade",
        attributes: &["deformation", "illumination-change", "occlusion"],
        frames: 180, ground: Ground::Plaza,
        target: Actor { look: 71, size: (23.0, 68.0),
            x: &[(0.0, 40.0), (80.0, 260.0), (100.0, 280.0), (180.0, 70.0)],
            y: &[(0.0, 120.0), (90.0, 140.0), (180.0, 110.0)], ..WALKER },
        front: &[
            Actor { kind: Kind::Post, look: 2, size: (30.0, 260.0), x: &[(0.0, 205.0)], y: &[(0.0, 120.0)],
                ..A },
        ],
        shadow: &[(0.0, 130.0), (180.0, 110.0)],
        shadow_width: 90.0,
        light: &[(0.0, 1.0), (90.0, 0.8), (180.0, 1.1)],
        ..P
    },
    // A motorcycle that turns over in the air.
    ScenePlan {
        name: "Somersault",
        attributes: &["background-clutter", "illumination-change", "in-plane-rotation", "motion-blur"],
        size: (400, 225), frames: 160, ground: Ground::Bricks,
        target: Actor { kind: Kind::Rider, look: 12, size: (68.0, 56.0),
            x: &[(0.0, 70.0), (60.0, 190.0), (110.0, 260.0), (160.0, 180.0)],
            y: &[(0.0, 150.0), (45.0, 140.0), (70.0, 70.0), (95.0, 130.0), (120.0, 148.0), (160.0, 150.0)],
            turn: &[(0.0, 0.0), (40.0, -10.0), (52.0, -40.0), (90.0, -340.0), (100.0, -360.0)], ..A },
        light: &[(0.0, 1.0), (50.0, 1.0), (70.0, 0.6), (100.0, 0.7), (160.0, 1.0)],
        shake: 2.0, exposure: 0.5,
        ..P
    },
    // Travellers before a wall.
    ScenePlan {
        name: "Subway",
        attributes: &["background-clutter", "deformation", "occlusion"],
        size: (352, 288), frames: 175, ground: Ground::Bricks,
        behind: &[
            Actor { look: 83, size: (28.0, 84.0), x: &[(0.0, 320.0), (175.0, 40.0)], y: &[(0.0, 204.0)],
                ..WALKER },
            Actor { look: 85, size: (28.0, 84.0), x: &[(0.0, 190.0), (175.0, 330.0)], y: &[(0.0, 206.0)],
                ..WALKER },
        ],
        target: Actor { look: 81, size: (29.0, 86.0), x: &[(0.0, 40.0), (120.0, 250.0), (175.0, 310.0)],
            y: &[(0.0, 212.0)], ..WALKER },
        front: &[
            Actor { look: 87, size: (32.0, 94.0), x: &[(0.0, 260.0), (70.0, 130.0), (175.0, 0.0)],
                y: &[(0.0, 218.0)], ..WALKER },
            Actor { look: 81, size: (30.0, 90.0), x: &[(0.0, 390.0), (100.0, 250.0), (175.0, 80.0)],
                y: &[(0.0, 222.0)], ..WALKER },
        ],
        noise: 10.0,
        ..P
    },
    // A ball that is hit to and fro.
    ScenePlan {
        name: "Tennis",
        attributes: &["fast-motion", "in-plane-rotation", "motion-blur"],
        frames: 190, ground: Ground::Meadow,
        target: Actor { kind: Kind::Ball, look: 3, size: (28.0, 28.0),
            x: &[(0.0, 60.0), (25.0, 110.0), (50.0, 180.0), (56.0, 270.0), (75.0, 280.0), (100.0, 200.0),
                (108.0, 60.0), (130.0, 70.0), (150.0, 170.0), (175.0, 200.0), (190.0, 205.0)],
            y: &[(0.0, 150.0), (12.0, 120.0), (25.0, 160.0), (40.0, 110.0), (56.0, 90.0), (75.0, 160.0),
                (90.0, 120.0), (108.0, 140.0), (120.0, 165.0), (135.0, 120.0), (150.0, 112.0),
                (190.0, 100.0)],
            turn: &[(0.0, 0.0), (50.0, 20.0), (56.0, 90.0), (100.0, 60.0), (108.0, -20.0), (150.0, 10.0)],
            ..A },
        exposure: 0.8,
        ..P
    },
    // A few pixels of a person, far away.
    ScenePlan {
        name: "Tower",
        attributes: &["background-clutter", "low-resolution", "occlusion"],
        size: (360, 240), frames: 200, ground: Ground::Plaza,
        behind: &[
            Actor { look: 93, size: (10.0, 28.0), x: &[(0.0, 250.0), (200.0, 120.0)],
                y: &[(0.0, 90.0), (200.0, 140.0)], ..WALKER },
            Actor { look: 91, size: (10.0, 28.0), x: &[(0.0, 330.0), (110.0, 160.0), (200.0, 60.0)],
                y: &[(0.0, 170.0), (110.0, 130.0), (200.0, 90.0)], ..WALKER },
        ],
        target: Actor { look: 91, size: (10.0, 28.0), x: &[(0.0, 60.0), (100.0, 160.0), (200.0, 290.0)],
            y: &[(0.0, 90.0), (100.0, 134.0), (200.0, 170.0)], ..WALKER },
        front: &[
            Actor { kind: Kind::Post, look: 4, size: (16.0, 60.0), x: &[(0.0, 228.0)], y: &[(0.0, 140.0)],
                ..A },
        ],
        noise: 10.0,
        ..P
    },
    // Somebody who walks up and down behind two pillars.
    ScenePlan {
        name: "Walker",
        attributes: &["deformation", "occlusion"],
        frames: 180, ground: Ground::Bricks,
        target: Actor { look: 101, x: &[(0.0, 40.0), (100.0, 270.0), (180.0, 80.0)], y: &[(0.0, 172.0)],
            ..WALKER },
        front: &[
            Actor { kind: Kind::Post, look: 4, size: (16.0, 250.0), x: &[(0.0, 120.0)], y: &[(0.0, 120.0)],
                ..A },
            Actor { kind: Kind::Post, look: 9, size: (34.0, 250.0), x: &[(0.0, 215.0)], y: &[(0.0, 120.0)],
                ..A },
        ],
        ..P
    },
];
