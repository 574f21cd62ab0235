//! One ray's JSON, checked: for `strahl rays` and `POST /v1/rays`.

use strahl::inspect::query::RayQuery;
use strahl::scene::limits;

/// Reads a ray; the error is a sentence.
pub(crate) fn read_ray(json: &str) -> Result<RayQuery, String> {
    let ray: RayQuery = serde_json::from_str(json).map_err(|error| format!("this is not a ray: {error}"))?;
    if ray.direction == [0.0; 3] {
        return Err("the direction has length 0; any other length will do".into());
    }
    if ray.origin.iter().any(|x| x.abs() > limits::MAGNITUDE) {
        return Err(format!("the origin must have coordinates between -{0:e} and {0:e}", limits::MAGNITUDE));
    }
    if ray.t_max.is_some_and(|t_max| t_max < ray.t_min) {
        return Err("t_max is below t_min, so no hit could count".into());
    }
    Ok(ray)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_need_a_direction() {
        assert!(read_ray(r#"{"origin":[0,0,0],"direction":[0,0,-2]}"#).is_ok());
        assert!(read_ray(r#"{"origin":[0,0,0],"direction":[0,-0,0]}"#).is_err());
        assert!(read_ray(r#"{"origin":[0,0,0],"direction":[0,0,1e999]}"#).is_err());
        assert!(read_ray(r#"{"origin":[0,0,0],"direction":[0,0,1],"t_min":2,"t_max":1}"#).is_err());
        assert!(read_ray(r#"{"origin":[0,0,0],"dir":[0,0,1]}"#).is_err());
    }
}
