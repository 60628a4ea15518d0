//! JSON schemas of the messages in the MCAP file: Foxglove's, by their names and fields, and our own.
//!
//! # Source
//! Foxglove's well-known message schemas: `foxglove.LocationFix`, `foxglove.FrameTransform`,
//! `foxglove.PoseInFrame`.

use serde_json::{Value, json};

fn object(properties: Value) -> Value {
    json!({"type": "object", "properties": properties})
}

fn numbers(names: &[&str]) -> Value {
    let named = names.iter().map(|name| ((*name).to_owned(), json!({"type": "number"})));
    object(Value::Object(named.collect()))
}

fn time() -> Value {
    object(json!({"sec": {"type": "integer"}, "nsec": {"type": "integer"}}))
}

pub fn location_fix() -> Value {
    let number = json!({"type": "number"});
    object(json!({
        "timestamp": time(),
        "frame_id": {"type": "string"},
        "latitude": number,
        "longitude": number,
        "altitude": number,
        "position_covariance": {"type": "array", "items": number},
        "position_covariance_type": {"type": "integer"},
    }))
}

pub fn pose_in_frame() -> Value {
    object(json!({
        "timestamp": time(),
        "frame_id": {"type": "string"},
        "pose": object(json!({
            "position": numbers(&["x", "y", "z"]),
            "orientation": numbers(&["x", "y", "z", "w"]),
        })),
    }))
}

pub fn frame_transform() -> Value {
    object(json!({
        "timestamp": time(),
        "parent_frame_id": {"type": "string"},
        "child_frame_id": {"type": "string"},
        "translation": numbers(&["x", "y", "z"]),
        "rotation": numbers(&["x", "y", "z", "w"]),
    }))
}

/// A message with one number for each column.
pub fn solution(columns: &[&str]) -> Value {
    numbers(columns)
}
